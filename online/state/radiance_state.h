// The state of every pixel: radiance, its variance, and the share of the newest frame. Move-only value.
#pragma once

#include "hal/core/image.h"

namespace hdrcam {

// The variance of a pixel that no frame saw unclipped: its radiance is a lower bound. Far above the
// variance from which on a pixel counts as unseen, by day after a night, too; its quotients by squares of
// what is barely visible are finite.
constexpr float kUnseenVariance = 1e30f;
// The variance from which on a pixel counts as unseen (`unseen_variance` elsewhere, in kernels
// `unseen_from`): nothing is known except that it is not black. white: the radiance that saturates the
// shortest of the newest exposures.
inline float unseen_variance_from(float white) { return 0.1f * white * white; }

struct RadianceEstimate {
  Image<float> radiance;  // [rgb, rows, cols]
  Image<float> variance;  // [rgb, rows, cols]
};

struct RadianceState : RadianceEstimate {
  Image<float> own_share;  // [1, rows, cols] 0..1: how much of the estimate is the newest frame's own sample

  void copy_from(const RadianceState& other) {
    radiance.copy_from(other.radiance);
    variance.copy_from(other.variance);
    own_share.copy_from(other.own_share);
  }
};

}  // namespace hdrcam
