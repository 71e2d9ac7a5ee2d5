// Scores along ground-truth motion: whether the picture changes where the scene does not, and the errors of
// estimated flow and depth. Positions between pixels are read bilinearly. Reentrant.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/core/image.h"
#include "render/scores/ground_truth.h"

namespace hdrcam {

struct RunningMean {
  double sum = 0;
  std::size_t count = 0;

  void add(double value) { sum += value, ++count; }
  void add(const std::optional<double>& value) {
    if (value) add(*value);
  }
  std::optional<double> mean() const {
    return count == 0 ? std::nullopt : std::optional<double>(sum / static_cast<double>(count));
  }
  RunningMean& operator+=(const RunningMean& other) { return sum += other.sum, count += other.count, *this; }
};

struct FlickerScores {
  RunningMean all;         // |d log2 estimate - d log2 truth| along the motion, stops per frame
  RunningMean background;  // the same on static objects
};

// log2 luminance of two neighbouring frames, [1, rows, cols] each, truth and estimate.
struct LogFrames {
  const Image<float>& truth;
  const Image<float>& estimate;
};

// motion: from `before` to `now`; moving: of `before`, or empty.
FlickerScores flicker(const LogFrames& before, const LogFrames& now, const MotionTruth& motion,
                      const Image<std::uint8_t>& moving);

// End-point error, pixels, of an estimated flow [dx dy, rows, cols], where the truth is comparable. Forward:
// the estimate belongs to the frame where `motion` starts. Backward: it belongs to the frame where `motion`
// ends and is compared there with the reversed truth.
RunningMean forward_flow_error(const Image<float>& estimate, const MotionTruth& motion);
RunningMean backward_flow_error(const Image<float>& estimate, const MotionTruth& motion);

// The unknown scales of a clip, of radiance and of depth, are medians of ratios over every 11th pixel.
inline constexpr std::size_t kRatioStride = 11;

// truth / estimate of depth, where both are above 0.
void collect_depth_ratios(const Image<float>& truth, const Image<float>& estimate,
                          std::vector<float>& ratios);
// |scale * estimate - truth| / truth where both are above 0.
RunningMean depth_error(const Image<float>& truth, const Image<float>& estimate, double scale);

}  // namespace hdrcam
