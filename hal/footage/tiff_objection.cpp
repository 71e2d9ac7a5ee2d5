#include "hal/footage/tiff_objection.h"

#include <fmt/format.h>

#include <cstddef>

namespace hdrcam {
namespace {

// TIFF 6.0, sections 2 (fields), 8 (baseline), 15 (tiles), 19 (data formats), 21 (YCbCr), 22 (JPEG); and
// TIFF Technical Note 1 (SubIFDs).
enum class TiffTag : std::uint32_t {
  NewSubfileType = 254,
  BitsPerSample = 258,
  Compression = 259,
  PhotometricInterpretation = 262,
  TileWidth = 322,
  SubIfds = 330,
  SampleFormat = 339,
};

class TiffFields {
 public:
  explicit TiffFields(std::span<const std::uint8_t> file) : file_(file), directory_(file.size()) {
    const auto order = number(0, 2);
    if (order == 0x4949u || order == 0x4d4du) little_ = order == 0x4949u;
    if (const auto first = number(4, 4); first && number(2, 2) == 42u) directory_ = *first;
  }

  // Goes to a directory at that place of the file.
  void enter(std::uint32_t place) { directory_ = place; }

  // The first value of a field; nullopt: the directory has none.
  std::optional<std::uint32_t> first_value(TiffTag tag) const {
    constexpr std::size_t kEntryBytes = 12, kInlineBytes = 4;
    const auto entries = number(directory_, 2);
    for (std::size_t i = 0; entries && i < *entries; ++i) {
      const std::size_t entry = directory_ + 2 + kEntryBytes * i;
      if (number(entry, 2) != static_cast<std::uint32_t>(tag)) continue;
      const std::size_t bytes = bytes_of_type(number(entry + 2, 2).value_or(0));
      const std::uint64_t count = number(entry + 4, 4).value_or(0);
      if (bytes == 0 || count == 0) return std::nullopt;
      const std::size_t payload = entry + 8;
      if (count * bytes <= kInlineBytes) return number(payload, bytes);
      const auto elsewhere = number(payload, 4);
      return elsewhere ? number(*elsewhere, bytes) : std::nullopt;
    }
    return std::nullopt;
  }

 private:
  // Of BYTE, SHORT, LONG and IFD; 0 of the others.
  static std::size_t bytes_of_type(std::uint32_t type) {
    constexpr std::uint32_t kByte = 1, kShort = 3, kLong = 4, kIfd = 13;
    return type == kByte ? 1 : type == kShort ? 2 : type == kLong || type == kIfd ? 4 : 0;
  }

  std::optional<std::uint32_t> number(std::size_t at, std::size_t bytes) const {
    if (at > file_.size() || bytes > file_.size() - at) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | file_[at + (little_ ? bytes - 1 - i : i)];
    return value;
  }

  const std::span<const std::uint8_t> file_;
  bool little_ = true;
  std::size_t directory_;  // its place; the end of what is no TIFF
};

}  // namespace

std::optional<std::string> objection_to_tiff(std::span<const std::uint8_t> file) {
  constexpr std::uint32_t kReducedSize = 1;                           // a bit of NewSubfileType
  constexpr std::uint32_t kOldJpeg = 6, kJpeg = 7;                    // Compression
  constexpr std::uint32_t kCmyk = 5, kYCbCr = 6;                      // PhotometricInterpretation
  constexpr std::uint32_t kUnsigned = 1, kFloat = 3, kUndefined = 4;  // SampleFormat
  constexpr const char* kInstead = "convert it to PNG of 8 or 16 bits";
  TiffFields fields(file);
  const auto says = [&fields](TiffTag tag, std::uint32_t otherwise) {
    return fields.first_value(tag).value_or(otherwise);
  };
  // As FFmpeg, which goes on to the picture that a preview in front of it refers to.
  if ((says(TiffTag::NewSubfileType, 0) & kReducedSize) != 0) {
    const auto picture = fields.first_value(TiffTag::SubIfds);
    if (!picture) return fmt::format("is a TIFF that begins with a preview; {}", kInstead);
    fields.enter(*picture);
  }
  if (fields.first_value(TiffTag::TileWidth))
    return fmt::format("is a TIFF in tiles, of which FFmpeg reads nothing; {}", kInstead);
  const std::uint32_t compression = says(TiffTag::Compression, 1);
  if (compression == kOldJpeg || compression == kJpeg)
    return fmt::format("is a TIFF with JPEG inside, which FFmpeg does not read; {}", kInstead);
  const std::uint32_t format = says(TiffTag::SampleFormat, kUnsigned);
  if (format != kUnsigned && format != kUndefined)
    return fmt::format("is a TIFF of {}, not of unsigned codes; {}",
                       format == kFloat ? "floating point" : fmt::format("sample format {}", format),
                       kInstead);
  const std::uint32_t colors = says(TiffTag::PhotometricInterpretation, 1);
  if (colors == kYCbCr || (colors == kCmyk && says(TiffTag::BitsPerSample, 1) != 8))
    return fmt::format("is a TIFF of {}, whose codes FFmpeg reads wrongly; {}",
                       colors == kCmyk ? "CMYK" : "YCbCr", kInstead);
  return std::nullopt;
}

}  // namespace hdrcam
