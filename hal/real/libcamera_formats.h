// PixelFormat and YuvCoding as libcamera names them. Reentrant.
#pragma once

#include <libcamera/color_space.h>
#include <libcamera/formats.h>
#include <libcamera/pixel_format.h>

#include <optional>

#include "hal/camera.h"

namespace hdrcam {

libcamera::PixelFormat libcamera_format_of(PixelFormat format);
std::optional<PixelFormat> format_of(const libcamera::PixelFormat& format);
YuvCoding coding_of(const libcamera::ColorSpace& space);

}  // namespace hdrcam
