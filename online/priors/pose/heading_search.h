// The first translation, before any depth is known: for each of a fixed set of headings, the small rotation
// that best explains the flow across the epipolar lines is a robust linear problem; PoseFitter refines the
// headings that explain most. (The linear part is the classical bilinear constraint of instantaneous motion:
// Heeger and Jepson 1992, "Subspace methods for recovering rigid motion".) Needs all points first seen from
// one place. Deterministic, no random samples. Reentrant.
#pragma once

#include <vector>

#include "online/priors/pose/pose_fit.h"

namespace hdrcam {

struct Heading {
  // With the length of the translation such that the median inverse depth is 1.
  RigidTransform T_camera_world;
  std::vector<double> inverse_depths;  // [points]
  double noise = 1;                    // of the flow across the epipolar lines, in sigmas (noise_across)
};

// turned: the pose of the best rotation without translation. Returns at most `count` headings, the best
// first, all clearly different from each other, and behind each that lies sideways its opposite with the turn
// that makes it explain the same flow.
std::vector<Heading> search_headings(std::span<const ScenePoint> points, const Intrinsics& lens,
                                     const RigidTransform& turned, int count);

}  // namespace hdrcam
