// 8-bit pictures as JPEG bytes (through libjpeg-turbo): baseline, 4:2:0, for a picture that is looked at and
// thrown away. Reentrant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/result.h"

namespace hdrcam {

// picture: [rgb, rows, cols] sRGB codes; quality: 1..100. Errors: Invalid (not three channels, empty, or more
// than 65500 pixels wide or high), Io (with libjpeg's message).
Result<std::vector<std::byte>> encode_jpeg(const Image<std::uint8_t>& picture, int quality);

}  // namespace hdrcam
