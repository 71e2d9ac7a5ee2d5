// A small analytic world for tests of pose and depth: a wall with a relief, a floor and spheres that may
// move; it gives the exact flow between two views and the exact depth. World = the first camera.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "hal/core/geometry.h"
#include "online/pictures/flow_field.h"

namespace hdrcam::test {

struct Sphere {
  Eigen::Vector3d centre;
  double radius = 1;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // per frame
};

struct SyntheticScene {
  int rows = 120, cols = 160;
  Intrinsics lens{150, 150, 80, 60};
  double wall_z = 7, floor_y = 1.2;
  bool relief = true;
  std::vector<Sphere> spheres;

  struct Hit {
    double depth = HUGE_VAL;  // camera z
    Eigen::Vector3d point_world;
    int sphere = -1;
  };

  Eigen::Vector3d ray(double u, double v) const {
    return {(u - lens.cx_px) / lens.fx_px, (v - lens.cy_px) / lens.fy_px, 1};
  }

  Hit cast(const RigidTransform& T_world_camera, double time, double u, double v) const {
    const Eigen::Vector3d d = T_world_camera.R * ray(u, v), o = T_world_camera.t;
    Hit hit;
    const auto consider = [&](double s, int sphere) {
      if (s > 1e-3 && s < hit.depth) hit = {s, o + s * d, sphere};
    };
    if (d.z() > 1e-6) {
      double s = (wall_z - o.z()) / d.z();
      // the relief is shallow: a few fixed point steps find it
      for (int k = 0; relief && k < 6; ++k) {
        const Eigen::Vector3d p = o + s * d;
        s = (wall_z + 0.8 * std::sin(1.1 * p.x()) * std::cos(1.3 * p.y()) - o.z()) / d.z();
      }
      consider(s, -1);
    }
    if (relief && d.y() > 1e-6) consider((floor_y - o.y()) / d.y(), -1);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      const Eigen::Vector3d to = o - (spheres[i].centre + time * spheres[i].velocity);
      const double a = d.squaredNorm(), b = d.dot(to),
                   c = to.squaredNorm() - spheres[i].radius * spheres[i].radius;
      if (b * b > a * c) consider((-b - std::sqrt(b * b - a * c)) / a, static_cast<int>(i));
    }
    return hit;
  }

  // Exact flow from the view at `from` to the view at `to`; confidence 0 where hidden or outside.
  FlowField flow(const RigidTransform& T_world_from, double from, const RigidTransform& T_world_to,
                 double to) const {
    FlowField field{Image<float>(2, rows, cols), Image<float>(1, rows, cols)};
    const RigidTransform T_to_world = T_world_to.inverse();
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        const Hit hit = cast(T_world_from, from, x + 0.5, y + 0.5);
        Eigen::Vector3d p = hit.point_world;
        if (hit.sphere >= 0) p += (to - from) * spheres[static_cast<std::size_t>(hit.sphere)].velocity;
        const Eigen::Vector3d q = T_to_world.R * p + T_to_world.t;
        const double u = lens.fx_px * q.x() / q.z() + lens.cx_px, v = lens.fy_px * q.y() / q.z() + lens.cy_px;
        field.vectors.at(0, y, x) = static_cast<float>(u - x - 0.5);
        field.vectors.at(1, y, x) = static_cast<float>(v - y - 0.5);
        const bool inside = u > 0 && v > 0 && u < cols && v < rows;
        field.confidence.at(0, y, x) =
            inside && cast(T_world_to, to, u, v).depth > 0.98 * q.z() ? 1.0f : 0.0f;
      }
    return field;
  }

  // share of dynamic pixels in the first view
  double dynamic_share() const {
    int dynamic = 0;
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        const int sphere = cast({}, 0, x + 0.5, y + 0.5).sphere;
        dynamic += sphere >= 0 && spheres[static_cast<std::size_t>(sphere)].velocity.norm() > 0;
      }
    return static_cast<double>(dynamic) / (rows * cols);
  }
};

// Noise as a dense flow has it: smooth over a patch of a few pixels.
inline void add_noise(FlowField& field, double sigma_px, std::mt19937& random) {
  constexpr int kPatch_px = 6;
  const int rows = field.vectors.rows(), cols = field.vectors.cols();
  std::normal_distribution<float> noise(0, static_cast<float>(sigma_px));
  Image<float> knots(2, rows / kPatch_px + 2, cols / kPatch_px + 2);
  for (float& v : knots.samples()) v = noise(random);
  for (int d = 0; d < 2; ++d)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        const int i = y / kPatch_px, j = x / kPatch_px;
        const float fy = static_cast<float>(y % kPatch_px) / kPatch_px,
                    fx = static_cast<float>(x % kPatch_px) / kPatch_px;
        field.vectors.at(d, y, x) += (1 - fy) * ((1 - fx) * knots.at(d, i, j) + fx * knots.at(d, i, j + 1)) +
                                     fy * ((1 - fx) * knots.at(d, i + 1, j) + fx * knots.at(d, i + 1, j + 1));
      }
}

// The flow both ways between consecutive frames of a path.
struct FramePair {
  FlowField to_previous, from_previous;
};

inline std::vector<FramePair> film(const SyntheticScene& scene,
                                   const std::vector<RigidTransform>& T_world_camera, double noise_px,
                                   unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<FramePair> frames(T_world_camera.size());
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double now = static_cast<double>(i), before = now - 1;
    frames[i].to_previous = scene.flow(T_world_camera[i], now, T_world_camera[i - 1], before);
    frames[i].from_previous = scene.flow(T_world_camera[i - 1], before, T_world_camera[i], now);
    add_noise(frames[i].to_previous, noise_px, random);
    add_noise(frames[i].from_previous, noise_px, random);
  }
  return frames;
}

inline std::vector<RigidTransform> straight_path(int frames, const Eigen::Vector3d& step,
                                                 const Eigen::Vector3d& turn_rad) {
  std::vector<RigidTransform> path;
  for (int i = 0; i < frames; ++i) path.push_back({rotation(i * turn_rad), i * step});
  return path;
}

}  // namespace hdrcam::test
