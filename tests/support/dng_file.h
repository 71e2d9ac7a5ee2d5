// Raw still files as cameras leave them: Adobe's Digital Negative 1.4, a TIFF with a mosaic whose codes are
// known.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace hdrcam::test {

// One directory of a TIFF file, little endian; entries are added in the order of their tags.
class TiffDirectory {
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

struct DngStill {
  int rows = 48, cols = 64;
  std::vector<std::uint8_t> pattern{0, 1, 1, 2};  // of the four sites: 0 red, 1 green, 2 blue
  std::uint32_t black = 256, white = 4000;        // codes
  std::uint32_t shutter_per_s = 250;              // the exposure is 1 / so much
  std::uint16_t iso = 400;
  std::vector<std::uint32_t> neutral{1, 2, 1, 1, 2, 3};  // AsShotNeutral, three fractions; empty: none
  std::string date_time, sub_second;                     // of EXIF; "": none
  std::vector<std::uint32_t> active_area;                // top, left, bottom, right; empty: all
  std::function<std::uint16_t(int, int)> code_at;        // by row and column
};

inline std::string write_dng(const std::string& path, const DngStill& still) {
  const auto rows = static_cast<std::uint32_t>(still.rows), cols = static_cast<std::uint32_t>(still.cols);
  // Offsets of one size whatever they are: the directory is as long with them as without.
  const auto directory = [&](std::uint32_t mosaic_at, std::uint32_t exif_at) {
    TiffDirectory dng;
    dng.longs(254, {0});
    dng.longs(256, {cols});
    dng.longs(257, {rows});
    dng.shorts(258, {16});
    dng.shorts(259, {1});
    dng.shorts(262, {32803});
    dng.text(271, "Maker");
    dng.text(272, "Model");
    dng.longs(273, {mosaic_at});
    dng.shorts(277, {1});
    dng.longs(278, {rows});
    dng.longs(279, {rows * cols * 2});
    dng.shorts(33421, {2, 2});
    dng.bytes(33422, still.pattern);
    dng.longs(34665, {exif_at});
    dng.bytes(50706, {1, 4, 0, 0});
    dng.text(50708, "Maker Model");
    dng.longs(50714, {still.black});
    dng.longs(50717, {still.white});
    dng.rationals(50721, 10, {1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1});
    if (!still.neutral.empty()) dng.rationals(50728, 5, still.neutral);
    if (!still.active_area.empty()) dng.longs(50829, still.active_area);
    return dng.at(8);
  };
  const auto mosaic_at = static_cast<std::uint32_t>(8 + directory(0, 0).size());
  const std::uint32_t exif_at = mosaic_at + rows * cols * 2;
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(mosaic_at, exif_at)) bytes.push_back(byte);
  for (int y = 0; y < still.rows; ++y)
    for (int x = 0; x < still.cols; ++x) TiffDirectory::put(bytes, still.code_at(y, x), 2);
  TiffDirectory exif;
  exif.rationals(33434, 5, {1, still.shutter_per_s});
  exif.rationals(33437, 5, {56, 10});
  exif.shorts(34855, {still.iso});
  if (!still.date_time.empty()) exif.text(36867, still.date_time);
  if (!still.sub_second.empty()) exif.text(37521, still.sub_second);
  for (const auto byte : exif.at(exif_at)) bytes.push_back(byte);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return path;
}

}  // namespace hdrcam::test
