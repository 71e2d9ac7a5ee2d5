// One directory of a TIFF file, little endian, as raw stills and EXIF have it (TIFF 6.0, section 2). Value
// type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hdrcam::test {

// Tags of TIFF 6.0, TIFF/EP, EXIF 2.3 and DNG 1.4.
namespace tiff_tag {
constexpr std::uint16_t kNewSubfileType = 254, kImageWidth = 256, kImageLength = 257, kBitsPerSample = 258,
                        kCompression = 259, kPhotometricInterpretation = 262, kMake = 271, kModel = 272,
                        kStripOffsets = 273, kOrientation = 274, kSamplesPerPixel = 277, kRowsPerStrip = 278,
                        kStripByteCounts = 279, kResolutionUnit = 296, kTileWidth = 322, kTileLength = 323,
                        kTileOffsets = 324, kTileByteCounts = 325, kSubIfds = 330, kSampleFormat = 339,
                        kCfaRepeatPatternDim = 33421, kCfaPattern = 33422, kExposureTime = 33434,
                        kFNumber = 33437, kExifDirectory = 34665, kIsoSpeed = 34855,
                        kRecommendedExposureIndex = 34866, kDateTimeOriginal = 36867,
                        kOffsetTimeOriginal = 36881, kShutterSpeedValue = 37377, kApertureValue = 37378,
                        kSubSecTimeOriginal = 37521, kFocalLengthIn35mmFilm = 41989, kDngVersion = 50706,
                        kUniqueCameraModel = 50708, kBlackLevelRepeatDim = 50713, kBlackLevel = 50714,
                        kWhiteLevel = 50717, kColorMatrix1 = 50721, kAsShotNeutral = 50728,
                        kActiveArea = 50829;
}  // namespace tiff_tag

// Entries are added in the order of their tags.
class TiffDirectory {
 public:
  void bytes(std::uint16_t tag, const std::vector<std::uint8_t>& values) {
    add(tag, Type::Byte, values.size(), values);
  }
  void text(std::uint16_t tag, const std::string& value) {
    std::vector<std::uint8_t> payload(value.begin(), value.end());
    payload.push_back(0);
    add(tag, Type::Ascii, payload.size(), payload);
  }
  void shorts(std::uint16_t tag, const std::vector<std::uint16_t>& values) {
    std::vector<std::uint8_t> payload;
    for (const auto value : values) put(payload, value, 2);
    add(tag, Type::Short, values.size(), payload);
  }
  void longs(std::uint16_t tag, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> payload;
    for (const auto value : values) put(payload, value, 4);
    add(tag, Type::Long, values.size(), payload);
  }
  // values: numerators and denominators in turn.
  void rationals(std::uint16_t tag, const std::vector<std::uint32_t>& values) {
    add_rationals(tag, Type::Rational, values);
  }
  void signed_rationals(std::uint16_t tag, const std::vector<std::uint32_t>& values) {
    add_rationals(tag, Type::SignedRational, values);
  }

  // The directory as it stands at `place` of the file: entries, then the payloads that do not fit into them.
  std::vector<std::uint8_t> at(std::size_t place) const {
    std::vector<std::uint8_t> head, far;
    put(head, static_cast<std::uint32_t>(entries_.size()), 2);
    const std::size_t begin_of_far = place + 2 + 12 * entries_.size() + 4;
    for (const Entry& entry : entries_) {
      put(head, entry.tag, 2), put(head, static_cast<std::uint32_t>(entry.type), 2);
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
  enum class Type : std::uint16_t {
    Byte = 1,
    Ascii = 2,
    Short = 3,
    Long = 4,
    Rational = 5,
    SignedRational = 10
  };
  struct Entry {
    std::uint16_t tag;
    Type type;
    std::size_t count;
    std::vector<std::uint8_t> payload;
  };
  void add(std::uint16_t tag, Type type, std::size_t count, const std::vector<std::uint8_t>& payload) {
    entries_.push_back({tag, type, count, payload});
  }
  void add_rationals(std::uint16_t tag, Type type, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> payload;
    for (const auto value : values) put(payload, value, 4);
    add(tag, type, values.size() / 2, payload);
  }
  std::vector<Entry> entries_;
};

}  // namespace hdrcam::test
