// OpenEXR pictures for scoring: planes by name, of the clip's size, finite. An estimate that is not is
// scored, not refused, with NaN and -Inf read as 0 and +Inf as 60000, and counted; a truth that is not is an
// error. Reentrant.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/storage.h"
#include "render/exr.h"

namespace hdrcam {

inline float finite_or_bound(float v) {
  constexpr float kInfinity = 6e4f;
  if (std::isfinite(v)) return v;
  return v > 0 ? kInfinity : 0;
}

// How many samples of those channels are NaN or infinite; 0 of a channel that the picture lacks.
std::size_t count_not_finite(const ExrImage& picture, std::span<const std::string_view> names);

// The samples of one channel, finite, to as many floats.
void copy_finite(const ExrImage& picture, int channel, float* to);

// One channel, finite: [1, rows, cols].
Image<float> plane_of(const ExrImage& picture, int channel);

// The channels R, G, B, finite: [rgb, rows, cols]. Errors: Unsupported where one of them is missing.
Result<Image<float>> rgb_of(const ExrImage& picture, const std::string& name);

// Of a picture of own_rows x own_cols. Errors: SizeChanged, naming both sizes.
inline Result<void> check_size(int own_rows, int own_cols, const std::string& name, int rows, int cols) {
  if (own_rows == rows && own_cols == cols) return {};
  return Error{ErrorCode::SizeChanged,
               fmt::format("'{}' is {}x{}, but the clip is {}x{}; compare pictures of one size", name,
                           own_cols, own_rows, cols, rows)};
}
template <class T>
Result<void> check_size(const Image<T>& picture, const std::string& name, int rows, int cols) {
  return check_size(picture.rows(), picture.cols(), name, rows, cols);
}

// A picture of the truth: read_exr, rgb_of and check_size in one. Errors: theirs; Corrupt where a sample is
// not finite, which would be compared as if it were 0.
Result<Image<float>> read_true_rgb(Storage& storage, const std::string& path, int rows, int cols);

}  // namespace hdrcam
