// The fields of the directories of a TIFF in memory (TIFF 6.0, section 2), of either byte order; nothing
// behind its end is read. Value type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace hdrcam {

// TIFF 6.0, sections 8 (baseline), 15 (tiles) and 19 (data formats); TIFF Technical Note 1 (SubIFDs).
enum class TiffTag : std::uint32_t {
  NewSubfileType = 254,
  BitsPerSample = 258,
  Compression = 259,
  PhotometricInterpretation = 262,
  StripOffsets = 273,
  Orientation = 274,
  StripByteCounts = 279,
  TileWidth = 322,
  TileOffsets = 324,
  TileByteCounts = 325,
  SubIfds = 330,
  SampleFormat = 339,
};

class TiffFields {
 public:
  // Of the first directory; the file outlives this. What is no TIFF has no fields.
  explicit TiffFields(std::span<const std::uint8_t> file);

  // Goes to the directory at that place of the file.
  void enter(std::uint32_t place) { directory_ = place; }

  // Of whole numbers: as many as the file has of those that the field states; empty where there is none.
  std::vector<std::uint32_t> values(TiffTag tag) const { return values(tag, SIZE_MAX); }
  std::optional<std::uint32_t> first_value(TiffTag tag) const;

 private:
  std::vector<std::uint32_t> values(TiffTag tag, std::size_t most) const;
  std::optional<std::uint32_t> number(std::size_t at, std::size_t bytes) const;

  std::span<const std::uint8_t> file_;
  bool little_endian_ = true;
  std::size_t directory_;  // its place; the end of what is no TIFF
};

}  // namespace hdrcam
