// The sinks that make pictures for people: preview and contact sheet.
#include <png.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "firmware_host/sinks/canvas.h"
#include "firmware_host/sinks/contact_sheet.h"
#include "firmware_host/sinks/preview.h"
#include "firmware_host/sinks/provenance_palette.h"
#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using sample::scratch_folder;
using test::emit;
using test::example_frame;
using test::With;

namespace {

struct Picture {
  int rows = 0, cols = 0;
  std::vector<std::uint8_t> rgb;

  Rgb at(int y, int x) const {
    const auto i =
        3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(cols) + static_cast<std::size_t>(x));
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
  long count(Rgb colour) const {
    long n = 0;
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) n += at(y, x) == colour;
    return n;
  }
};

Picture decoded(std::span<const std::byte> png) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&header, png.data(), png.size()) != 0);
  header.format = PNG_FORMAT_RGB;
  Picture picture{static_cast<int>(header.height), static_cast<int>(header.width), {}};
  picture.rgb.resize(PNG_IMAGE_SIZE(header));
  REQUIRE(png_image_finish_read(&header, nullptr, picture.rgb.data(), 0, nullptr) != 0);
  return picture;
}

Picture read_png(const std::string& path) {
  const auto bytes = read_whole(posix_storage(), path);
  REQUIRE(bytes.ok());
  return decoded(std::as_bytes(std::span(bytes.value())));
}

}  // namespace

TEST_CASE("the preview shows brighter radiance brighter, the same way in every frame") {
  const std::string folder = scratch_folder("preview");
  auto sink = create_preview(posix_storage(), folder + "/%03d.png");
  REQUIRE(sink.ok());
  REQUIRE(emit(*sink.value(), example_frame(0)).ok());
  REQUIRE(emit(*sink.value(), example_frame(1)).ok());
  REQUIRE(sink.value()->finish().ok());
  const Picture first = read_png(folder + "/000.png"), second = read_png(folder + "/001.png");
  CHECK(first.cols == 32);
  CHECK(first.rows == 24);
  CHECK(first.rgb == second.rgb);
  for (int x = 1; x < 32; ++x) CHECK(first.at(5, x).g >= first.at(5, x - 1).g);
  CHECK(first.at(5, 31).g > 200);
  CHECK(first.at(5, 0).g < 60);
}

TEST_CASE("a preview on a full disk is an error") {
  const std::string folder = scratch_folder("preview-full");
  FaultyStorage full(posix_storage(), test::disk_of(10));
  auto sink = create_preview(full, folder + "/%03d.png");
  REQUIRE(sink.ok());
  CHECK(emit(*sink.value(), example_frame(0)).error().code == ErrorCode::NoSpace);
  CHECK(std::filesystem::is_empty(folder));
}

TEST_CASE("a contact sheet of a long clip shows four rows from its beginning to its end") {
  const std::string folder = scratch_folder("sheet");
  ContactSheet sheet(posix_storage(), folder + "/sheet.png");
  Image<float> codes(3, 24, 32);
  for (std::uint64_t sequence = 0; sequence < 500; ++sequence) {
    // Rows can be told apart by the red of their input: it grows along the clip.
    std::fill_n(codes.plane(0), codes.plane_size(), static_cast<float>(sequence) / 2);
    REQUIRE(emit(sheet, example_frame(sequence), codes).ok());
  }
  REQUIRE(sheet.finish().ok());
  const Picture picture = read_png(folder + "/sheet.png");
  const Picture same = decoded(sheet.png());
  CHECK(picture.rgb == same.rgb);
  std::vector<int> reds;  // of the first column's cells, from top to bottom
  for (int y = 0; y < picture.rows; ++y) {
    const Rgb pixel = picture.at(y, 8 + 16);
    const bool input = pixel.g == 0 && pixel.b == 0;
    if (input && (reds.empty() || reds.back() != pixel.r)) reds.push_back(pixel.r);
  }
  REQUIRE(reds.size() == 4);
  CHECK(reds.front() == 0);
  CHECK(reds.back() > 0.75 * 250);
  CHECK(std::is_sorted(reds.begin(), reds.end()));
  for (const ProvenanceLook& look : kProvenanceLooks) CHECK(picture.count(look.colour) > 24 * 5 * 4);
}

namespace {

Picture sheet_of(const HdrFrame& frame) {
  ContactSheet sheet(posix_storage(), "");
  const Image<float> codes(3, frame.radiance.rows(), frame.radiance.cols());
  REQUIRE(emit(sheet, frame, codes).ok());
  REQUIRE(sheet.finish().ok());
  return decoded(sheet.png());
}

}  // namespace

TEST_CASE("the cells of a contact sheet do not overlap where a film is of another size than its input") {
  for (const auto& [rows, cols] : {std::pair{240, 320}, {96, 16}, {24, 64}}) {
    CAPTURE(rows, cols);
    ContactSheet sheet(posix_storage(), "");
    Image<float> codes(3, 24, 32);
    std::fill_n(codes.plane(0), codes.plane_size(), 250.f);  // red, as nothing else of a sheet
    for (std::uint64_t sequence = 0; sequence < 4; ++sequence)
      REQUIRE(emit(sheet, example_frame(sequence, With::RadianceOnly, rows, cols), codes).ok());
    REQUIRE(sheet.finish().ok());
    const Picture picture = decoded(sheet.png());
    CHECK(picture.count({250, 0, 0}) == 4 * 24 * 32);
    for (const ProvenanceLook& look : kProvenanceLooks)
      CHECK(picture.count(look.colour) >= 4 * rows * (cols / 5));  // and its square in the legend
  }
}

TEST_CASE("a contact sheet has a column of depth only where there is depth") {
  const auto width_with = [](With with) { return sheet_of(example_frame(0, with, 240, 320)).cols; };
  CHECK(width_with(With::DepthAndFlow) == width_with(With::RadianceOnly) + 320 + 8);
}

TEST_CASE("the rows of a contact sheet show every exposure of the cycle, whatever the clip's length") {
  for (const int slots : {2, 3, 4})
    for (const std::uint64_t frames : {4, 7, 10, 12, 13, 21, 28, 61, 100, 121, 500}) {
      ContactSheet sheet(posix_storage(), "");
      Image<float> codes(3, 24, 32);
      for (std::uint64_t sequence = 0; sequence < frames; ++sequence) {
        const auto slot = static_cast<int>(sequence % static_cast<std::uint64_t>(slots));
        HdrFrame frame = example_frame(sequence);
        frame.exposure = std::exp2(static_cast<float>(slot));
        std::fill_n(codes.plane(0), codes.plane_size(), static_cast<float>(50 + 50 * slot));
        REQUIRE(emit(sheet, frame, codes).ok());
      }
      REQUIRE(sheet.finish().ok());
      const Picture picture = decoded(sheet.png());
      std::set<int> reds;  // of the inputs
      for (int y = 0; y < picture.rows; ++y)
        if (const Rgb pixel = picture.at(y, 8 + 16); pixel.g == 0 && pixel.b == 0) reds.insert(pixel.r);
      INFO(slots << " exposures, " << frames << " frames");
      CHECK(reds.size() == static_cast<std::size_t>(slots));
    }
}

TEST_CASE("the words on a contact sheet of small frames have room, and none is drawn over another") {
  for (const int cols : {32, 64, 160}) {
    const Picture sheet = sheet_of(example_frame(0, With::DepthAndFlow, 24, cols));
    const int of_titles = text_width("input", 9) + text_width("HDR, tone-mapped", 9) +
                          text_width("provenance", 9) + text_width("inverse depth (near is bright)", 9);
    CHECK(sheet.cols > of_titles);
    int margin = 0;  // columns of paper at the right
    const auto is_paper = [&](int x) {
      for (int y = 0; y < sheet.rows; ++y)
        if (sheet.at(y, x) != Rgb{24, 26, 30}) return false;
      return true;
    };
    while (margin < sheet.cols && is_paper(sheet.cols - 1 - margin)) ++margin;
    CHECK(margin >= 4);
  }
}

TEST_CASE("a contact sheet is grey where the depth is not known") {
  HdrFrame frame = example_frame(0, With::DepthAndFlow, 24, 320);
  const long before = sheet_of(frame).count({96, 96, 96});
  for (int x = 0; x < 320; ++x) frame.depth.at(0, 3, x) = 0;
  CHECK(sheet_of(frame).count({96, 96, 96}) >= before + 320);
}

TEST_CASE("large frames are shrunk to cells, and a run without frames has no sheet") {
  ContactSheet sheet(posix_storage(), "");
  REQUIRE(sheet.finish().ok());
  CHECK(sheet.png().empty());
  const Image<float> codes(3, 480, 640);
  REQUIRE(emit(sheet, example_frame(0, With::DepthAndFlow, 480, 640), codes).ok());
  REQUIRE(sheet.finish().ok());
  CHECK(decoded(sheet.png()).cols == 4 * 320 + 5 * 8);
}

TEST_CASE("drawing outside a canvas is cut off") {
  Canvas canvas(10, 10, {1, 2, 3});
  canvas.paste(8, 8, Image<std::uint8_t>(3, 5, 5));
  canvas.paste(20, 0, Image<std::uint8_t>(1, 5, 5));
  canvas.fill(-2, -2, 4, 4, {9, 9, 9});
  canvas.write(30, 50, "outside", 9, {255, 255, 255});
  CHECK(canvas.picture().at(0, 9, 9) == 0);
  CHECK(canvas.picture().at(1, 5, 5) == 2);
  CHECK(canvas.picture().at(2, 1, 1) == 9);
}

TEST_CASE("what is pasted above and left of a canvas shows its far corner") {
  Image<std::uint8_t> picture(1, 4, 5);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 5; ++x) picture.at(0, y, x) = static_cast<std::uint8_t>(10 * y + x + 100);
  Canvas canvas(10, 10, {1, 2, 3});
  canvas.paste(-1, -3, picture);
  canvas.paste(-9, 0, picture);
  canvas.paste(0, -5, picture);
  for (int c = 0; c < 3; ++c) {
    CHECK(canvas.picture().at(c, 0, 0) == 113);
    CHECK(canvas.picture().at(c, 2, 1) == 134);
    CHECK(canvas.picture().at(c, 0, 2) == c + 1);
    CHECK(canvas.picture().at(c, 3, 0) == c + 1);
    CHECK(canvas.picture().at(c, 9, 9) == c + 1);
  }
}
