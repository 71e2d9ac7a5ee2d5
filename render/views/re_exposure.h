// The 8-bit picture that the camera would have taken: radiance through an exposure and the camera's own
// response, without noise and black level, which nobody wants back. It is held as the light that an sRGB
// display shows of its codes, code = 255 sRGB(light), so that it goes where radiance goes. Reentrant.
#pragma once

#include <cstdint>

#include "hal/core/image.h"
#include "online/response/response.h"

namespace hdrcam {

// picture: [rgb, rows, cols] radiance, which becomes the light, 0..1; exposure: E / E_ref.
void expose_again(double exposure, const Response& response, Image<float>& picture);

// The codes of such light, [rgb, rows, cols], exactly as the response gave them.
Image<std::uint8_t> codes_of_light(const Image<float>& light);

}  // namespace hdrcam
