// PNG pictures of codes, 8 or 16 bits a sample, grey or RGB. The samples are those of the file: no gamma, no
// colour management. A damaged file is an error, never a crash. Reentrant.
#pragma once

#include <cstdint>
#include <string>

#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

struct PngImage {
  int bits_per_sample = 8;       // 8 or 16
  Image<std::uint16_t> samples;  // [1 or 3 channels, rows, cols], 0 .. 2^bits_per_sample-1
};

// Reads a PNG of exactly cols x rows pixels. Palettes are expanded, alpha is dropped. Errors: NotFound,
// Permission; SizeChanged; Unsupported for grey of fewer than 8 bits; Corrupt. Messages begin with the path.
Result<PngImage> read_png(Storage& storage, const std::string& path, int cols, int rows);

// Writes the whole file or nothing. Errors: Permission, NoSpace, Io.
Result<void> write_png(Storage& storage, const std::string& path, const PngImage& image);

}  // namespace hdrcam
