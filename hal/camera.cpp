#include "hal/camera.h"

namespace hdrcam {

const char* name(PixelFormat format) {
  switch (format) {
    case PixelFormat::Rgb24:
      return "RGB24";
    case PixelFormat::Bgr24:
      return "BGR24";
    case PixelFormat::Yuyv:
      return "YUYV";
    case PixelFormat::Nv12:
      return "NV12";
    case PixelFormat::Mjpeg:
      return "MJPEG";
    case PixelFormat::Grey8:
      return "GREY8";
    case PixelFormat::Rggb8:
      return "RGGB8";
    case PixelFormat::Grbg8:
      return "GRBG8";
    case PixelFormat::Gbrg8:
      return "GBRG8";
    case PixelFormat::Bggr8:
      return "BGGR8";
    case PixelFormat::Rggb10:
      return "RGGB10";
    case PixelFormat::Grbg10:
      return "GRBG10";
    case PixelFormat::Gbrg10:
      return "GBRG10";
    case PixelFormat::Bggr10:
      return "BGGR10";
    case PixelFormat::Rggb12:
      return "RGGB12";
    case PixelFormat::Grbg12:
      return "GRBG12";
    case PixelFormat::Gbrg12:
      return "GBRG12";
    case PixelFormat::Bggr12:
      return "BGGR12";
    case PixelFormat::Rggb16:
      return "RGGB16";
    case PixelFormat::Grbg16:
      return "GRBG16";
    case PixelFormat::Gbrg16:
      return "GBRG16";
    case PixelFormat::Bggr16:
      return "BGGR16";
    case PixelFormat::Rggb10Packed:
      return "RGGB10P";
    case PixelFormat::Grbg10Packed:
      return "GRBG10P";
    case PixelFormat::Gbrg10Packed:
      return "GBRG10P";
    case PixelFormat::Bggr10Packed:
      return "BGGR10P";
    case PixelFormat::Rggb12Packed:
      return "RGGB12P";
    case PixelFormat::Grbg12Packed:
      return "GRBG12P";
    case PixelFormat::Gbrg12Packed:
      return "GBRG12P";
    case PixelFormat::Bggr12Packed:
      return "BGGR12P";
  }
  return "?";
}

std::optional<PixelFormat> pixel_format(std::string_view text) {
  for (int i = 0; i <= static_cast<int>(PixelFormat::Bggr12Packed); ++i)
    if (const auto format = static_cast<PixelFormat>(i); text == name(format)) return format;
  return std::nullopt;
}

Result<void> check_exposure(const CameraCapabilities& camera, const ExposureRequest& request) {
  if (!camera.sets_exposure) return {};
  const auto microseconds = [](Duration d) { return static_cast<double>(d.count()) * 1e-3; };
  if (request.exposure < camera.exposure_min || request.exposure > camera.exposure_max)
    return Error{ErrorCode::Invalid,
                 fmt::format("camera '{}' cannot expose for {:.1f} us; it offers {:.1f} to {:.1f} us",
                             camera.id, microseconds(request.exposure), microseconds(camera.exposure_min),
                             microseconds(camera.exposure_max))};
  constexpr double kRounding = 1e-6;  // of limits that were computed from a code
  const double gain = request.analogue_gain;
  if (!(gain >= camera.gain_min * (1 - kRounding) && gain <= camera.gain_max * (1 + kRounding)))
    return Error{ErrorCode::Invalid,
                 fmt::format("camera '{}' cannot amplify by {:.3f}; it offers {:.3f} to {:.3f}", camera.id,
                             gain, camera.gain_min, camera.gain_max)};
  return {};
}

}  // namespace hdrcam
