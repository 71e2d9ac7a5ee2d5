#include "render/scores/linear_pictures.h"

#include <algorithm>

namespace hdrcam {

void copy_finite(const ExrImage& picture, int channel, float* to) {
  const float* from = picture.samples.plane(channel);
  std::transform(from, from + picture.samples.plane_size(), to, finite_or_bound);
}

Image<float> plane_of(const ExrImage& picture, int channel) {
  Image<float> plane(1, picture.samples.rows(), picture.samples.cols());
  copy_finite(picture, channel, plane.plane(0));
  return plane;
}

Result<Image<float>> rgb_of(const ExrImage& picture, const std::string& name) {
  Image<float> rgb(3, picture.samples.rows(), picture.samples.cols());
  for (int c = 0; c < 3; ++c) {
    const auto channel = picture.find(exr_channel::kRadiance[c]);
    if (!channel)
      return Error{ErrorCode::Unsupported, fmt::format("'{}' has no channel '{}'; radiance is R, G and B",
                                                       name, exr_channel::kRadiance[c])};
    copy_finite(picture, *channel, rgb.plane(c));
  }
  return rgb;
}

Result<Image<float>> read_linear_rgb(Storage& storage, const std::string& path, int rows, int cols) {
  const ExrImage picture = TRY(read_exr(storage, path));
  Image<float> rgb = TRY(rgb_of(picture, path));
  TRY(check_size(rgb, path, rows, cols));
  return rgb;
}

}  // namespace hdrcam
