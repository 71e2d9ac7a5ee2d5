#include "hal/footage/tiff_objection.h"

#include <fmt/format.h>

#include "hal/footage/tiff_fields.h"

namespace hdrcam {

// TIFF 6.0, sections 8, 15 (tiles), 19 (sample formats), 21 (YCbCr) and 22 (JPEG).
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
