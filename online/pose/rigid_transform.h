// A rotation and a translation: p_dst = R p_src + t. Value type, reentrant.
#pragma once

#include <Eigen/Dense>

#include "hal/core/frame.h"

namespace hdrcam {

struct RigidTransform {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  RigidTransform inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
  bool finite() const { return R.allFinite() && t.allFinite(); }
  friend RigidTransform operator*(const RigidTransform& T_a_b, const RigidTransform& T_b_c) {
    return {T_a_b.R * T_b_c.R, T_a_b.R * T_b_c.t + T_a_b.t};
  }
};

// exp of an axis times an angle in radians
inline Eigen::Matrix3d rotation(const Eigen::Vector3d& axis_angle) {
  const double angle = axis_angle.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, axis_angle / angle).toRotationMatrix()
                   : Eigen::Matrix3d::Identity();
}

// The nearest rotation: products of many rotations stay rotations.
inline Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0).finished();
}

// Of a PoseMatrix: row-major 3x4.
inline std::size_t entry(int row, int col) {
  return static_cast<std::size_t>(row) * 4 + static_cast<std::size_t>(col);
}

inline RigidTransform from_matrix(const PoseMatrix& m) {
  RigidTransform T;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) T.R(row, col) = m[entry(row, col)];
    T.t(row) = m[entry(row, 3)];
  }
  return T;
}

inline PoseMatrix to_matrix(const RigidTransform& T) {
  PoseMatrix m{};
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) m[entry(row, col)] = T.R(row, col);
    m[entry(row, 3)] = T.t(row);
  }
  return m;
}

}  // namespace hdrcam
