// Decodes the frames of a camera that sends MJPEG: baseline JPEG, one scan, usually without the Huffman
// tables, which are then those of the standard (ISO/IEC 10918-1 K.3; USB Video Class, payload MJPEG). A
// damaged frame is an error, never a crash and never a picture that is partly grey.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "hal/core/image.h"
#include "hal/core/result.h"

namespace hdrcam {

// rgb: [rgb, rows, cols], 8-bit codes, full range; the caller sets the stream's size. Errors: Corrupt, with
// the reason, also for a picture of another size, which is refused before anything is decoded; rgb is
// undefined then.
using DecodeJpeg = std::function<Result<void>(std::span<const std::byte> jpeg, Image<std::uint16_t>& rgb)>;

// A decoder with its own memory, thread-bound. It calls no `new` after the first picture; libjpeg allocates
// and frees its working memory with each.
DecodeJpeg jpeg_decoder();

}  // namespace hdrcam
