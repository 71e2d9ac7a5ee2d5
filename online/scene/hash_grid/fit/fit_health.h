// Monitors the fit: a step whose loss or gradient is not finite is skipped, an exploding loss restores the
// last good copy of the parameters, an outlier gradient is scaled down. All these events are counted. Value
// type.
#pragma once

#include <algorithm>
#include <cmath>

namespace hdrcam {

enum class StepVerdict {
  Taken,
  Skipped,     // loss or gradient not finite
  RolledBack,  // loss exploded
};

struct FitCounts {
  long steps = 0;  // requested
  long skipped = 0, rolled_back = 0, clipped = 0, restarted = 0;
  long without_dynamic = 0;  // steps without the dynamic branch
  long anchors_moved = 0;
};

class FitHealth {
 public:
  static constexpr double kExploded = 20;      // times the usual loss, and at least ..
  static constexpr double kSmallLoss = 0.05;   // .. times this: a new frame may multiply a loss near zero
  static constexpr double kLargeGradient = 5;  // times the usual norm
  static constexpr int kWarmUp = 20;           // steps before the usual values are known
  static constexpr int kMemory = 50;           // steps that usual values are the mean of
  static constexpr int kPatience = 3;          // roll-backs without a step taken between them

  StepVerdict judge(double loss, double gradient_norm) {
    ++counts_.steps;
    if (!std::isfinite(loss) || !std::isfinite(gradient_norm)) return ++counts_.skipped, StepVerdict::Skipped;
    if (seen_ >= kWarmUp && loss > kExploded * std::max(usual_loss_, kSmallLoss)) {
      ++counts_.rolled_back, ++in_a_row_;
      return StepVerdict::RolledBack;
    }
    const double rate = 1.0 / (1 + seen_);
    usual_loss_ += rate * (loss - usual_loss_);
    scale_ = 1;
    if (seen_ >= kWarmUp && gradient_norm > kLargeGradient * usual_norm_ && usual_norm_ > 0) {
      scale_ = kLargeGradient * usual_norm_ / gradient_norm;
      ++counts_.clipped;
    }
    usual_norm_ += rate * (scale_ * gradient_norm - usual_norm_);
    seen_ = std::min(seen_ + 1, kMemory);
    in_a_row_ = 0;
    return StepVerdict::Taken;
  }

  // for the gradient of the step just taken
  float gradient_scale() const { return static_cast<float>(scale_); }
  // the last good copy fails too: the networks are reinitialised
  bool is_lost() const { return in_a_row_ >= kPatience; }
  void restart() { forget(), ++counts_.restarted; }
  // what was usual is of another time
  void forget() { seen_ = in_a_row_ = 0; }

  FitCounts& counts() { return counts_; }
  const FitCounts& counts() const { return counts_; }

 private:
  FitCounts counts_;
  double usual_loss_ = 0, usual_norm_ = 0, scale_ = 1;
  int seen_ = 0, in_a_row_ = 0;
};

}  // namespace hdrcam
