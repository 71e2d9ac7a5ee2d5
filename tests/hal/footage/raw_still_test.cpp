// Raw stills, read back from DNG files that are written here (Adobe's Digital Negative 1.4: a TIFF with a
// mosaic).
#include "hal/footage/raw_still.h"

#include <cstdint>
#include <fstream>
#include <vector>

#include "hal/footage/footage.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

constexpr int kRows = 48, kCols = 64, kBlack = 256, kWhite = 4000;

// One directory of a TIFF file, little endian; entries are added in the order of their tags.
class Dng {
 public:
  void bytes(std::uint16_t tag, const std::vector<std::uint8_t>& values) {
    add(tag, 1, values.size(), values);
  }
  void text(std::uint16_t tag, const std::string& value) {
    std::vector<std::uint8_t> payload(value.begin(), value.end());
    payload.push_back(0);
    add(tag, 2, payload.size(), payload);
  }
  void shorts(std::uint16_t tag, const std::vector<std::uint16_t>& values) {
    std::vector<std::uint8_t> payload;
    for (const auto value : values) put(payload, value, 2);
    add(tag, 3, values.size(), payload);
  }
  void longs(std::uint16_t tag, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> payload;
    for (const auto value : values) put(payload, value, 4);
    add(tag, 4, values.size(), payload);
  }
  void rationals(std::uint16_t tag, std::uint16_t type, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> payload;
    for (const auto value : values) put(payload, value, 4);
    add(tag, type, values.size() / 2, payload);
  }

  // The directory as it stands at `place` of the file: entries, then the payloads that do not fit into them.
  std::vector<std::uint8_t> at(std::size_t place) const {
    std::vector<std::uint8_t> head, far;
    put(head, static_cast<std::uint32_t>(entries_.size()), 2);
    const std::size_t begin_of_far = place + 2 + 12 * entries_.size() + 4;
    for (const Entry& entry : entries_) {
      put(head, entry.tag, 2), put(head, entry.type, 2),
          put(head, static_cast<std::uint32_t>(entry.count), 4);
      if (entry.payload.size() > 4) {
        put(head, static_cast<std::uint32_t>(begin_of_far + far.size()), 4);
        for (const auto byte : entry.payload) far.push_back(byte);
        if (far.size() % 2 == 1) far.push_back(0);
      } else {
        for (std::size_t i = 0; i < 4; ++i) head.push_back(i < entry.payload.size() ? entry.payload[i] : 0);
      }
    }
    put(head, 0, 4);
    for (const auto byte : far) head.push_back(byte);
    return head;
  }

  static void put(std::vector<std::uint8_t>& to, std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::size_t count;
    std::vector<std::uint8_t> payload;
  };
  void add(std::uint16_t tag, std::uint16_t type, std::size_t count,
           const std::vector<std::uint8_t>& payload) {
    entries_.push_back({tag, type, count, payload});
  }
  std::vector<Entry> entries_;
};

std::uint16_t code_at(int y, int x) { return static_cast<std::uint16_t>((y * 71 + x * 53) % 4096); }

// pattern: of the four sites, 0 red, 1 green, 2 blue.
std::string write_dng(const std::string& path, const std::vector<std::uint8_t>& pattern,
                      std::uint32_t shutter_per_s, std::uint16_t iso) {
  // Offsets of one size whatever they are: the directory is as long with them as without.
  const auto directory = [&](std::uint32_t mosaic_at, std::uint32_t exif_at) {
    Dng dng;
    dng.longs(254, {0});
    dng.longs(256, {kCols});
    dng.longs(257, {kRows});
    dng.shorts(258, {16});
    dng.shorts(259, {1});
    dng.shorts(262, {32803});
    dng.text(271, "Maker");
    dng.text(272, "Model");
    dng.longs(273, {mosaic_at});
    dng.shorts(277, {1});
    dng.longs(278, {kRows});
    dng.longs(279, {kRows * kCols * 2});
    dng.shorts(33421, {2, 2});
    dng.bytes(33422, pattern);
    dng.longs(34665, {exif_at});
    dng.bytes(50706, {1, 4, 0, 0});
    dng.text(50708, "Maker Model");
    dng.longs(50714, {kBlack});
    dng.longs(50717, {kWhite});
    dng.rationals(50721, 10, {1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1});
    dng.rationals(50728, 5, {1, 2, 1, 1, 1, 2});
    return dng.at(8);
  };
  const auto mosaic_at = static_cast<std::uint32_t>(8 + directory(0, 0).size());
  const std::uint32_t exif_at = mosaic_at + kRows * kCols * 2;
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(mosaic_at, exif_at)) bytes.push_back(byte);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) Dng::put(bytes, code_at(y, x), 2);
  Dng exif;
  exif.rationals(33434, 5, {1, shutter_per_s});
  exif.rationals(33437, 5, {56, 10});
  exif.shorts(34855, {iso});
  for (const auto byte : exif.at(exif_at)) bytes.push_back(byte);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return path;
}

}  // namespace

TEST_CASE("a raw still is the mosaic of its sensor, linear, with black level and exposure") {
  const std::string folder = sample::scratch_folder("raw_still");
  const std::pair<PixelLayout, std::vector<std::uint8_t>> patterns[] = {
      {PixelLayout::BayerRggb, {0, 1, 1, 2}},
      {PixelLayout::BayerGrbg, {1, 0, 2, 1}},
      {PixelLayout::BayerGbrg, {1, 2, 0, 1}},
      {PixelLayout::BayerBggr, {2, 1, 1, 0}}};
  for (const auto& [layout, pattern] : patterns) {
    auto footage = open_footage(posix_storage(), {write_dng(folder + "/x.DNG", pattern, 250, 400)}, 0);
    INFO((footage.ok() ? "" : footage.error().message));
    REQUIRE(footage.ok());
    const CameraFacts& camera = footage.value()->camera();
    CHECK(camera.layout == layout);
    CHECK(camera.linear);
    CHECK(camera.bits == 12);
    REQUIRE(camera.width == kCols);
    REQUIRE(camera.height == kRows);
    RawFrame frame;
    REQUIRE(footage.value()->next(frame).value());
    int wrong = 0;
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x)
        wrong += frame.codes.at(0, y, x) != (code_at(y, x) >= kWhite ? 4095 : code_at(y, x)) ? 1 : 0;
    CHECK(wrong == 0);
    REQUIRE(frame.facts.black_level);
    CHECK(frame.facts.black_level->code(12) == Approx(kBlack));
    CHECK(frame.facts.exposure_source == ExposureSource::Embedded);
    CHECK(frame.facts.exposure_s == Approx(0.004));
    CHECK(frame.facts.analogue_gain == Approx(4));
    CHECK_FALSE(footage.value()->next(frame).value());
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
