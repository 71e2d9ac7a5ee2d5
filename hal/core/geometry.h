// Rigid transforms, as Eigen matrices: T_dst_src takes p_src to p_dst = R p_src + t. Camera axes x right, y
// down, z forward; metres or the unit that the owner states. Value types, reentrant.
#pragma once

#include <Eigen/Core>

#include "hal/core/pose_matrix.h"

namespace hdrcam {

struct RigidTransform {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;

  RigidTransform();  // the identity
  RigidTransform(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);

  RigidTransform inverse() const;
  bool finite() const;
  // finite, and R a rotation within 1e-3
  bool is_rigid() const;
};

RigidTransform operator*(const RigidTransform& T_a_b, const RigidTransform& T_b_c);
bool operator==(const RigidTransform& a, const RigidTransform& b);

// exp of an axis times an angle in radians
Eigen::Matrix3d rotation(const Eigen::Vector3d& axis_angle);

// The nearest rotation: products of many rotations stay rotations.
Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& R);

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

RigidTransform transform_of(const PoseMatrix& rows);
PoseMatrix pose_matrix_of(const RigidTransform& T);

}  // namespace hdrcam
