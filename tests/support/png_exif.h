// A PNG whose EXIF states how its picture is turned. Include it last: it brings Catch2.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>

#include "tests/support/tiff_directory.h"

#include "tests/support/files.h"

namespace hdrcam::test {

// PNG, third edition, 11.3.4.5: behind the head, a TIFF with one field.
inline void add_exif_to_png(const std::string& path, std::uint16_t orientation) {
  constexpr std::size_t kHeadEnd = 8 + 25;
  TiffDirectory fields;
  fields.shorts(tiff_tag::kOrientation, {orientation});
  std::string exif("eXIfII\x2a\0\x08\0\0\0", 12);
  for (const auto byte : fields.at(8)) exif += static_cast<char>(byte);
  const auto checksum = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(exif.data()), static_cast<uInt>(exif.size())));
  const auto in_bytes = [](std::uint32_t value) {
    std::string text;
    for (const int shift : {24, 16, 8, 0}) text += static_cast<char>(value >> shift & 0xff);
    return text;
  };
  std::string bytes = text_of(path);
  bytes.insert(kHeadEnd, in_bytes(static_cast<std::uint32_t>(exif.size() - 4)) + exif + in_bytes(checksum));
  write_file(path, bytes);
}

}  // namespace hdrcam::test
