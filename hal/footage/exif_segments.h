// The EXIF segments of a JPEG (Exif 2.32, 4.5.4): one, but programs that edit pictures have left files with
// two. Readers of EXIF take the first; FFmpeg takes each field from the last that has it. Reentrant.
#pragma once

#include <cstdint>
#include <span>

namespace hdrcam {

// Makes those behind the first unknown to every reader. jpeg: all of a picture; what is none, or is damaged,
// is left to the decoder.
void hide_later_exif(std::span<std::uint8_t> jpeg);

}  // namespace hdrcam
