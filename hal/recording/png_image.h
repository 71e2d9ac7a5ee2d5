// PNG pictures of codes, 8 or 16 bits a sample, grey or RGB. The samples are those of the file: no gamma, no
// colour management; what they mean may be said in the file. A damaged file is an error, never a crash.
// Reentrant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// What RGB samples are to a display: code points of ITU-T H.273.
struct PngColors {
  std::uint8_t primaries = 2, transfer = 2;  // 2: unspecified
};

struct PngImage {
  int bits_per_sample = 8;               // 8 or 16
  Image<std::uint16_t> samples;          // [1 or 3 channels, rows, cols], 0 .. 2^bits_per_sample-1
  std::optional<PngColors> colors = {};  // of a cICP chunk, full range; not read
};

// Reads a PNG of exactly cols x rows pixels. Palettes are expanded, alpha is dropped. Errors: NotFound,
// Permission; SizeChanged; Unsupported for grey of fewer than 8 bits; Corrupt. Messages begin with the path.
Result<PngImage> read_png(Storage& storage, const std::string& path, int cols, int rows);

enum class PngEase { Small, Fast };  // Fast: for pictures that are looked at once

// The bytes of the file. Errors: Io with libpng's message.
Result<std::vector<std::byte>> png_file(const PngImage& image, PngEase ease = PngEase::Small);

// Writes the whole file or nothing. Errors: Permission, NoSpace, Io.
Result<void> write_png(Storage& storage, const std::string& path, const PngImage& image);

}  // namespace hdrcam
