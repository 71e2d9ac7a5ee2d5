// PixelFormat as the kernel names it: the FourCC of a capture queue and the media bus code of a sensor.
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
// The FourCC as text ("YUYV"), for messages about an unsupported format.
std::string fourcc_text(std::uint32_t fourcc);

}  // namespace hdrcam
