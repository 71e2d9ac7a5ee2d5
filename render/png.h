// 8-bit pictures as PNG bytes (through libpng). Reentrant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/result.h"

namespace hdrcam {

enum class PngEffort { Fast, Small };  // Fast: for one picture per frame; about a fifth larger

// picture: [1 or rgb, rows, cols] sRGB codes. Errors: Invalid (empty, or another number of channels), Io
// (with libpng's message).
Result<std::vector<std::byte>> encode_png(const Image<std::uint8_t>& picture,
                                          PngEffort effort = PngEffort::Fast);

}  // namespace hdrcam
