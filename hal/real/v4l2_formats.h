// PixelFormat in the kernel's words: the four characters of a capture queue and the code of a sensor's bus.
// Reentrant.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hal/camera.h"

namespace hdrcam {

std::uint32_t fourcc_of(PixelFormat format);
std::optional<PixelFormat> format_of(std::uint32_t fourcc);
// MEDIA_BUS_FMT_*; 0 for formats that no sensor sends over a bus.
std::uint32_t bus_code_of(PixelFormat format);
// "YUYV", for a sentence about a format that is not ours.
std::string fourcc_text(std::uint32_t fourcc);

}  // namespace hdrcam
