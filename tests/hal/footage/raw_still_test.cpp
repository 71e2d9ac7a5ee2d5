// Raw stills, read back from DNG files that are written here.
#include "hal/footage/raw_still.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <vector>

#include "hal/footage/footage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/dng_file.h"
#include "tests/support/files.h"
#include "tests/support/stored_as.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

std::uint16_t code_at(int y, int x) { return static_cast<std::uint16_t>((y * 71 + x * 53) % 4096); }

// The code that is read of a code of twelve bits with this white level.
int stretched(int code, int white = static_cast<int>(test::DngStill{}.white)) {
  return code >= white ? 4095 : static_cast<int>(std::lround(code * 4095.0 / white));
}
int stretched_at(int y, int x) { return stretched(code_at(y, x)); }

}  // namespace

TEST_CASE("a raw still is the mosaic of its sensor, linear, with black level and exposure") {
  const std::string folder = sample::scratch_folder("raw_still");
  const std::pair<PixelLayout, std::vector<std::uint8_t>> patterns[] = {
      {PixelLayout::BayerRggb, {0, 1, 1, 2}},
      {PixelLayout::BayerGrbg, {1, 0, 2, 1}},
      {PixelLayout::BayerGbrg, {1, 2, 0, 1}},
      {PixelLayout::BayerBggr, {2, 1, 1, 0}}};
  for (const auto& [layout, pattern] : patterns) {
    test::DngStill still;
    still.pattern = pattern, still.code_at = code_at;
    auto footage = open_footage(posix_storage(), {test::write_dng(folder + "/x.DNG", still)}, 0);
    INFO((footage.ok() ? "" : footage.error().message));
    REQUIRE(footage.ok());
    const CameraFacts& camera = footage.value()->camera();
    CHECK(camera.layout == layout);
    CHECK(camera.linear);
    CHECK(camera.bits == 12);
    REQUIRE(camera.width == still.cols);
    REQUIRE(camera.height == still.rows);
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    int wrong = 0;
    for (int y = 0; y < still.rows; ++y)
      for (int x = 0; x < still.cols; ++x) wrong += frame.codes.at(0, y, x) != stretched_at(y, x) ? 1 : 0;
    CHECK(wrong == 0);
    REQUIRE(frame.facts.black_level);
    CHECK(frame.facts.black_level->code(12) == Approx(256 * 4095 / 4000.0));
    CHECK(frame.facts.exposure_source == ExposureSource::Embedded);
    CHECK(frame.facts.exposure_s == Approx(0.004));
    CHECK(frame.facts.analogue_gain == Approx(4));
    CHECK_FALSE(footage.value()->next(frame).value());
  }
}

TEST_CASE("a white level of 4096 is that of codes of twelve bits, of which the largest is clipped") {
  test::DngStill still;
  still.white = 4096, still.code_at = [](int, int x) { return static_cast<std::uint16_t>(4095 - x); };
  const std::string path = sample::scratch_folder("raw_still_white") + "/x.dng";
  auto footage = open_footage(posix_storage(), {test::write_dng(path, still)}, 0);
  REQUIRE(footage.ok());
  CHECK(footage.value()->camera().bits == 12);
  RawFrame frame;
  REQUIRE(footage.value()->next(frame).value());
  CHECK(frame.codes.at(0, 0, 0) == 4095);
  CHECK(frame.codes.at(0, 0, 1) == 4094);
}

TEST_CASE(
    "the white level of a raw still becomes the largest code, and each code below it a code of its own") {
  const std::string folder = sample::scratch_folder("raw_still_stretched");
  test::DngStill still;
  still.rows = still.cols = 64;
  still.code_at = [](int y, int x) { return static_cast<std::uint16_t>(64 * y + x); };
  for (const std::uint32_t white : {2100u, 3880u, 4094u}) {
    CAPTURE(white);
    still.white = white;
    auto footage = open_footage(posix_storage(), {test::write_dng(folder + "/x.dng", still)}, 0);
    REQUIRE(footage.ok());
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    int alike = 0;
    for (unsigned code = 1; code <= white; ++code)
      alike += frame.codes.samples()[code] <= frame.codes.samples()[code - 1] ? 1 : 0;
    CHECK(alike == 0);
    CHECK(frame.codes.samples()[white] == 4095);
    CHECK(frame.codes.samples()[4095] == 4095);
    CHECK(frame.codes.samples()[white / 2] == Approx(2047.5).margin(1.5));
  }
}

TEST_CASE("all raw stills of a clip are stretched alike, and each is clipped where it says") {
  const std::string folder = sample::scratch_folder("raw_still_whites");
  std::vector<std::string> files;
  for (const std::uint32_t white : {3900u, 4000u, 3000u}) {
    test::DngStill still;
    still.white = white;
    still.code_at = [](int, int x) { return static_cast<std::uint16_t>(2000 + 32 * x); };
    files.push_back(test::write_dng(fmt::format("{}/{}.dng", folder, white), still));
  }
  auto footage = open_footage(posix_storage(), files, 0);
  REQUIRE(footage.ok());
  for (const int white : {3900, 4000, 3000}) {
    CAPTURE(white);
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    for (const int x : {0, 20, 32, 58, 60}) {
      const int code = 2000 + 32 * x;
      CHECK(frame.codes.at(0, 5, x) == (code >= white ? 4095 : stretched(code, 3900)));
    }
    CHECK(frame.facts.black_level->code(12) == Approx(256 * 4095 / 3900.0));
  }
}

TEST_CASE("the black level of a raw still keeps the fractions that its file states") {
  test::DngStill still;
  still.black_tenths = {2566, 2567, 2568, 2567}, still.code_at = code_at;
  const std::string path = sample::scratch_folder("raw_still_black") + "/x.dng";
  auto footage = open_footage(posix_storage(), {test::write_dng(path, still)}, 0);
  REQUIRE(footage.ok());
  RawFrame frame;
  REQUIRE(footage.value()->next(frame).value());
  REQUIRE(frame.facts.black_level);
  CHECK(frame.facts.black_level->code(12) == Approx(256.7 * 4095 / 4000).margin(1e-3));
}

TEST_CASE("a raw still's sensitivity beyond 65535 is the one that EXIF states beside it") {
  const std::string folder = sample::scratch_folder("raw_still_iso");
  test::DngStill still;
  still.code_at = code_at, still.iso = 65535;
  for (const std::uint32_t index : {204800u, 0u}) {
    CAPTURE(index);
    still.exposure_index = index;
    auto footage = open_footage(posix_storage(), {test::write_dng(folder + "/x.dng", still)}, 0);
    REQUIRE(footage.ok());
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    CHECK(footage.value()->factors().iso == (index > 0));  // 65535 alone may be any
    if (index > 0) CHECK(frame.facts.analogue_gain == Approx(2048));
  }
}

TEST_CASE("a raw still carries the white balance of its camera and the time at which it was taken") {
  const std::string folder = sample::scratch_folder("raw_still_facts");
  test::DngStill still;
  still.code_at = code_at;
  still.date_time = "2026:11:22 17:03:04", still.sub_second = "25";
  auto footage = open_footage(posix_storage(), {test::write_dng(folder + "/a.dng", still)}, 0);
  REQUIRE(footage.ok());
  REQUIRE(footage.value()->camera().white_balance);
  const ChannelGains& gains = *footage.value()->camera().white_balance;  // 1 / AsShotNeutral
  CHECK(gains[0] == Approx(2));
  CHECK(gains[1] == 1);
  CHECK(gains[2] == Approx(1.5));
  RawFrame frame;
  REQUIRE(footage.value()->next(frame).value());
  const auto taken = footage.value()->taken();
  REQUIRE(taken);
  CHECK(taken->local == exif_time("2026:11:22 17:03:04", "25", "")->local);
  CHECK(taken->tick == std::chrono::milliseconds(10));

  still.neutral = {1, 100, 1, 1, 1, 1};  // red times 100: no white balance, and no reason to refuse the still
  footage = open_footage(posix_storage(), {test::write_dng(folder + "/odd.dng", still)}, 0);
  REQUIRE(footage.ok());
  CHECK_FALSE(footage.value()->camera().white_balance);

  still.neutral.clear(), still.date_time.clear(), still.sub_second.clear();
  footage = open_footage(posix_storage(), {test::write_dng(folder + "/b.dng", still)}, 0);
  REQUIRE(footage.ok());
  CHECK_FALSE(footage.value()->camera().white_balance);
  REQUIRE(footage.value()->next(frame).value());
  CHECK_FALSE(footage.value()->taken());
}

TEST_CASE("a raw still that states its focal length for 35 mm film has a lens") {
  test::DngStill still;
  still.code_at = code_at;
  const std::string path = sample::scratch_folder("raw_still_lens") + "/x.dng";
  auto footage = open_footage(posix_storage(), {test::write_dng(path, still)}, 0);
  REQUIRE(footage.ok());
  CHECK_FALSE(footage.value()->camera().intrinsics);
  still.focal_35mm_mm = 50;
  footage = open_footage(posix_storage(), {test::write_dng(path, still)}, 0);
  REQUIRE(footage.ok());
  REQUIRE(footage.value()->camera().intrinsics);
  CHECK(footage.value()->camera().intrinsics->fx_px == Approx(92.45).margin(0.01));  // of 80 pixels' diagonal
}

TEST_CASE("a raw still whose exposure time is divided by zero does not state it") {
  test::DngStill still;
  still.code_at = code_at, still.shutter_per_s = 0;
  const std::string path = sample::scratch_folder("raw_still_endless") + "/x.dng";
  auto footage = open_footage(posix_storage(), {test::write_dng(path, still)}, 0);
  REQUIRE(footage.ok());
  RawFrame frame;
  REQUIRE(footage.value()->next(frame).value());
  CHECK(frame.facts.exposure_source == ExposureSource::Unknown);
}

TEST_CASE(
    "a raw still is turned upright by the orientation that it states, and so is the pattern of its mosaic") {
  const std::string path = sample::scratch_folder("raw_still_turned") + "/x.dng";
  const Image<std::uint16_t> upright = [] {
    Image<std::uint16_t> codes(1, 48, 64);
    for (int y = 0; y < codes.rows(); ++y)
      for (int x = 0; x < codes.cols(); ++x) codes.at(0, y, x) = code_at(y, x);
    return codes;
  }();
  // Of mosaics that are stored with red first, and have even sides.
  const std::pair<std::uint16_t, PixelLayout> patterns[] = {
      {1, PixelLayout::BayerRggb}, {2, PixelLayout::BayerGrbg}, {3, PixelLayout::BayerBggr},
      {4, PixelLayout::BayerGbrg}, {5, PixelLayout::BayerRggb}, {6, PixelLayout::BayerGrbg},
      {7, PixelLayout::BayerBggr}, {8, PixelLayout::BayerGbrg}};
  for (const auto& [orientation, pattern] : patterns) {
    CAPTURE(orientation);
    const Image<std::uint16_t> stored = test::stored_as(orientation, upright);
    test::DngStill still;
    still.orientation = orientation;
    still.rows = stored.rows(), still.cols = stored.cols();
    still.code_at = [&stored](int y, int x) { return stored.at(0, y, x); };
    auto footage = open_footage(posix_storage(), {test::write_dng(path, still)}, 0);
    REQUIRE(footage.ok());
    CHECK(footage.value()->camera().layout == pattern);
    REQUIRE(footage.value()->camera().width == 64);
    REQUIRE(footage.value()->camera().height == 48);
    CHECK(footage.value()->orientations()[0].orientation == orientation_of_exif(orientation));
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    int wrong = 0;
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) wrong += frame.codes.at(0, y, x) != stretched_at(y, x) ? 1 : 0;
    CHECK(wrong == 0);
  }
}

TEST_CASE("raw stills of other makers go to LibRaw, which knows them by their content") {
  const std::string folder = sample::scratch_folder("raw_still_names");
  test::DngStill still;
  still.code_at = code_at;
  for (const char* name : {"/a.SRW", "/b.nrw", "/c.RWL", "/d.3fr", "/e.iiq", "/f.ERF"}) {
    CAPTURE(name);
    CHECK(is_footage(name));
    auto footage = open_footage(posix_storage(), {test::write_dng(folder + name, still)}, 0);
    REQUIRE(footage.ok());
    CHECK(footage.value()->camera().layout == PixelLayout::BayerRggb);
  }
}

TEST_CASE("a raw still whose picture reaches beyond its raw data is damaged") {
  const std::string folder = sample::scratch_folder("raw_still_beyond");
  test::DngStill still;
  still.rows = still.cols = 64, still.code_at = code_at;
  still.active_area = {8, 4, 64, 64};
  auto footage = open_footage(posix_storage(), {test::write_dng(folder + "/inside.dng", still)}, 0);
  REQUIRE(footage.ok());
  CHECK(footage.value()->camera().width == 60);
  CHECK(footage.value()->camera().height == 56);
  RawFrame frame;
  REQUIRE(footage.value()->next(frame).value());
  CHECK(frame.codes.at(0, 0, 0) == stretched_at(8, 4));
  for (const std::vector<std::uint32_t>& area :
       {std::vector<std::uint32_t>{32, 32, 96, 96}, {0, 32, 64, 96}}) {
    still.active_area = area;
    const auto beyond = open_footage(posix_storage(), {test::write_dng(folder + "/beyond.dng", still)}, 0);
    CHECK(sample::error_of(beyond).code == ErrorCode::Corrupt);
    CHECK_THAT(sample::error_of(beyond).message, Contains("beyond.dng") && Contains("reaches beyond"));
  }
}

TEST_CASE("a DNG in tiles comes as its mosaic, or is refused where LibRaw mixes the tiles up") {
  const std::string folder = sample::scratch_folder("raw_still_tiles");
  test::DngStill still;
  still.rows = still.cols = 64, still.code_at = code_at;
  for (const std::uint32_t tile_px : {32u, 48u, 64u}) {
    CAPTURE(tile_px);
    still.tile_px = tile_px;
    auto footage = open_footage(posix_storage(), {test::write_dng(folder + "/tiles.dng", still)}, 0);
    if (!footage && tile_px != 64) {
      CHECK(footage.error().code == ErrorCode::Unsupported);
      CHECK_THAT(footage.error().message, Contains("tiles.dng") && Contains("in tiles without compression"));
      continue;
    }
    REQUIRE(footage.ok());  // one tile is the picture
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    CHECK(frame.codes.at(0, 3, 5) == stretched_at(3, 5));
    CHECK(frame.codes.at(0, 50, 61) == stretched_at(50, 61));
  }
}

TEST_CASE("a raw still of which a part is missing or does not decode is damaged, not black") {
  const std::string folder = sample::scratch_folder("raw_still_parts"), path = folder + "/x.dng";
  const auto refusal = [&path](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    return sample::error_of(open_footage(posix_storage(), {path}, 0));
  };
  test::DngStill still;
  still.rows = still.cols = 64, still.code_at = code_at;
  still.packing = test::DngPacking::LosslessJpeg;
  for (const std::uint32_t tile_px : {0u, 48u}) {
    CAPTURE(tile_px);
    still.tile_px = tile_px;
    const std::string whole = test::text_of(test::write_dng(path, still));
    const auto footage = open_footage(posix_storage(), {path}, 0);
    REQUIRE(footage.ok());
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    CHECK(frame.codes.at(0, 50, 61) == stretched_at(50, 61));
    const std::size_t last_part = whole.rfind("\xff\xd8\xff\xc3");  // begins there
    for (const std::size_t size : {last_part, last_part + 20}) {
      const Error cut = refusal(whole.substr(0, size));
      CHECK(cut.code == ErrorCode::Corrupt);
      CHECK_THAT(cut.message, Contains(path) && Contains("it was cut"));
    }
    std::string wrong = whole;
    wrong.replace(last_part + 200, 64, 64, 'U');
    const Error refused = refusal(wrong);
    CHECK(refused.code == ErrorCode::Corrupt);
    CHECK_THAT(refused.message, Contains(path) && Contains("do not decode"));
  }
}

TEST_CASE("a raw still that is damaged, or none, is an error that names it") {
  const std::string folder = sample::scratch_folder("raw_still_wrong");
  std::ofstream(folder + "/text.nef") << "no raw still\n";
  const auto none = open_footage(posix_storage(), {folder + "/text.nef"}, 0);
  CHECK(sample::error_of(none).code == ErrorCode::NotRecording);
  CHECK_THAT(sample::error_of(none).message, Contains("text.nef"));
  CHECK(sample::error_of(open_footage(posix_storage(), {folder + "/missing.cr2"}, 0)).code ==
        ErrorCode::NotFound);
}

TEST_CASE("a camera is called by its make and model, and not where no model is stated") {
  CHECK(camera_model("Canon ", "EOS R5\t") == "Canon EOS R5");
  CHECK(camera_model(" ", "EOS R5") == "EOS R5");
  CHECK(camera_model("", "").empty());
  CHECK(camera_model("Canon", " ").empty());
}
