#include "render/scores/linear_pictures.h"

#include <algorithm>

namespace hdrcam {

std::size_t count_not_finite(const ExrImage& picture, std::span<const std::string_view> names) {
  std::size_t count = 0;
  for (const std::string_view name : names)
    if (const auto channel = picture.find(name)) {
      const float* samples = picture.samples.plane(*channel);
      count += static_cast<std::size_t>(std::count_if(samples, samples + picture.samples.plane_size(),
                                                      [](float v) { return !std::isfinite(v); }));
    }
  return count;
}

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

Result<Image<float>> read_true_rgb(Storage& storage, const std::string& path, int rows, int cols) {
  const ExrImage picture = TRY(read_exr(storage, path));
  Image<float> rgb = TRY(rgb_of(picture, path));
  TRY(check_size(rgb, path, rows, cols));
  if (const std::size_t broken = count_not_finite(picture, exr_channel::kRadiance); broken > 0)
    return Error{ErrorCode::Corrupt,
                 fmt::format("'{}' has NaN or infinity in {} of its {} samples; nothing can be compared with "
                             "them, so write the truth again",
                             path, broken, rgb.size())};
  return rgb;
}

}  // namespace hdrcam
