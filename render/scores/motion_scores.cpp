#include "render/scores/motion_scores.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace hdrcam {
namespace {

// OpenCV only reads the picture that it remaps.
cv::Mat view(const Image<float>& image, int channel) {
  return {image.rows(), image.cols(), CV_32F, const_cast<float*>(image.plane(channel))};
}

// An image sampled at the end of each motion vector, zero outside. One value per pixel of the frame where the
// vectors start.
class FarEnd {
 public:
  explicit FarEnd(const MotionTruth& motion) {
    const int rows = motion.flow.rows(), cols = motion.flow.cols();
    x_.create(rows, cols, CV_32F), y_.create(rows, cols, CV_32F);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < cols; ++x) {
        x_.at<float>(y, x) = static_cast<float>(x) + motion.flow.at(0, y, x);
        y_.at<float>(y, x) = static_cast<float>(y) + motion.flow.at(1, y, x);
      }
    }
  }

  cv::Mat read(const Image<float>& image, int channel = 0) const {
    cv::Mat out;
    cv::remap(view(image, channel), out, x_, y_, cv::INTER_LINEAR);
    return out;
  }

 private:
  cv::Mat x_, y_;
};

}  // namespace

FlickerScores flicker(const LogFrames& before, const LogFrames& now, const MotionTruth& motion,
                      const Image<std::uint8_t>& moving) {
  const FarEnd far_end(motion);
  const cv::Mat estimate = far_end.read(now.estimate), truth = far_end.read(now.truth);
  FlickerScores scores;
  for (int y = 0; y < truth.rows; ++y) {
    for (int x = 0; x < truth.cols; ++x) {
      if (motion.comparable.at(0, y, x) == 0) continue;
      const float estimate_change = estimate.at<float>(y, x) - before.estimate.at(0, y, x);
      const float truth_change = truth.at<float>(y, x) - before.truth.at(0, y, x);
      const double error = static_cast<double>(std::abs(estimate_change - truth_change));
      scores.all.add(error);
      if (moving.empty() || moving.at(0, y, x) == 0) scores.background.add(error);
    }
  }
  return scores;
}

RunningMean forward_flow_error(const Image<float>& estimate, const MotionTruth& motion) {
  RunningMean error;
  for (std::size_t i = 0; i < motion.comparable.size(); ++i) {
    if (motion.comparable.plane(0)[i] == 0) continue;
    error.add(static_cast<double>(std::hypot(estimate.plane(0)[i] - motion.flow.plane(0)[i],
                                             estimate.plane(1)[i] - motion.flow.plane(1)[i])));
  }
  return error;
}

RunningMean backward_flow_error(const Image<float>& estimate, const MotionTruth& motion) {
  const FarEnd far_end(motion);
  const cv::Mat dx = far_end.read(estimate, 0), dy = far_end.read(estimate, 1);
  RunningMean error;
  for (int y = 0; y < dx.rows; ++y) {
    for (int x = 0; x < dx.cols; ++x) {
      if (motion.comparable.at(0, y, x) == 0) continue;
      error.add(static_cast<double>(std::hypot(dx.at<float>(y, x) + motion.flow.at(0, y, x),
                                               dy.at<float>(y, x) + motion.flow.at(1, y, x))));
    }
  }
  return error;
}

void collect_depth_ratios(const Image<float>& truth, const Image<float>& estimate,
                          std::vector<float>& ratios) {
  for (std::size_t i = 0; i < truth.size(); i += kRatioStride)
    if (truth.plane(0)[i] > 0 && estimate.plane(0)[i] > 0)
      ratios.push_back(truth.plane(0)[i] / estimate.plane(0)[i]);
}

RunningMean depth_error(const Image<float>& truth, const Image<float>& estimate, double scale) {
  RunningMean error;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double t = static_cast<double>(truth.plane(0)[i]), e = static_cast<double>(estimate.plane(0)[i]);
    if (t > 0 && e > 0) error.add(std::abs(scale * e - t) / t);
  }
  return error;
}

}  // namespace hdrcam
