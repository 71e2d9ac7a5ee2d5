#include "hal/camera.h"

#include <iterator>

namespace hdrcam {
namespace {

using enum PixelFormat;
constexpr struct {
  PixelFormat format;
  const char* name;
} kNames[] = {{Rgb24, "RGB24"},
              {Bgr24, "BGR24"},
              {Yuyv, "YUYV"},
              {Uyvy, "UYVY"},
              {Nv12, "NV12"},
              {Mjpeg, "MJPEG"},
              {Grey8, "GREY8"},
              {Grey10, "GREY10"},
              {Grey12, "GREY12"},
              {Grey10Packed, "GREY10P"},
              {Rggb8, "RGGB8"},
              {Grbg8, "GRBG8"},
              {Gbrg8, "GBRG8"},
              {Bggr8, "BGGR8"},
              {Rggb10, "RGGB10"},
              {Grbg10, "GRBG10"},
              {Gbrg10, "GBRG10"},
              {Bggr10, "BGGR10"},
              {Rggb12, "RGGB12"},
              {Grbg12, "GRBG12"},
              {Gbrg12, "GBRG12"},
              {Bggr12, "BGGR12"},
              {Rggb16, "RGGB16"},
              {Grbg16, "GRBG16"},
              {Gbrg16, "GBRG16"},
              {Bggr16, "BGGR16"},
              {Rggb10Packed, "RGGB10P"},
              {Grbg10Packed, "GRBG10P"},
              {Gbrg10Packed, "GBRG10P"},
              {Bggr10Packed, "BGGR10P"},
              {Rggb12Packed, "RGGB12P"},
              {Grbg12Packed, "GRBG12P"},
              {Gbrg12Packed, "GBRG12P"},
              {Bggr12Packed, "BGGR12P"}};
static_assert(std::size(kNames) == static_cast<std::size_t>(Bggr12Packed) + 1);

}  // namespace

const char* name(PixelFormat format) {
  for (const auto& named : kNames)
    if (named.format == format) return named.name;
  return "?";
}

std::optional<PixelFormat> pixel_format(std::string_view text) {
  for (const auto& named : kNames)
    if (named.name == text) return named.format;
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
