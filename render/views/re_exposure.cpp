#include "render/views/re_exposure.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/srgb.h"

namespace hdrcam {

void expose_again(double exposure, const Response& response, Image<float>& picture) {
  std::array<float, Response::kCodes> light{};
  for (std::size_t code = 0; code < light.size(); ++code)
    light[code] = srgb_light(static_cast<float>(code) / (Response::kCodes - 1));
  const auto factor = static_cast<float>(exposure);
  for (int c = 0; c < picture.channels(); ++c)
    std::transform(
        picture.plane(c), picture.plane(c) + picture.plane_size(), picture.plane(c), [&](float radiance) {
          return light[static_cast<std::size_t>(std::lround(response.code_of(c, radiance * factor)))];
        });
}

Image<std::uint8_t> codes_of_light(const Image<float>& light) {
  Image<std::uint8_t> codes(light.channels(), light.rows(), light.cols());
  std::ranges::transform(light.samples(), codes.samples().begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(255 * srgb_level(value)));
  });
  return codes;
}

}  // namespace hdrcam
