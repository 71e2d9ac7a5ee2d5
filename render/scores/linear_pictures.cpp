#include "render/scores/linear_pictures.h"

#include <algorithm>

namespace hdrcam {
namespace {

void copy_finite(const float* from, std::size_t count, float* to) {
  std::transform(from, from + count, to, finite_or_bound);
}

}  // namespace

Image<float> plane_of(const ExrImage& picture, int channel) {
  Image<float> plane(1, picture.samples.rows(), picture.samples.cols());
  copy_finite(picture.samples.plane(channel), plane.size(), plane.plane(0));
  return plane;
}

Result<Image<float>> rgb_of(const ExrImage& picture, const std::string& name) {
  Image<float> rgb(3, picture.samples.rows(), picture.samples.cols());
  for (int c = 0; c < 3; ++c) {
    const auto channel = picture.find(exr_channel::kRadiance[c]);
    if (!channel)
      return Error{ErrorCode::Unsupported, fmt::format("'{}' has no channel '{}'; radiance is R, G and B",
                                                       name, exr_channel::kRadiance[c])};
    copy_finite(picture.samples.plane(*channel), rgb.plane_size(), rgb.plane(c));
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
