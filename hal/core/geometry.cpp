#include "hal/core/geometry.h"

#include <Eigen/Geometry>

namespace hdrcam {

RigidTransform::RigidTransform() : R(Eigen::Matrix3d::Identity()), t(Eigen::Vector3d::Zero()) {}

RigidTransform::RigidTransform(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation)
    : R(rotation), t(translation) {}

RigidTransform RigidTransform::inverse() const { return {R.transpose(), -(R.transpose() * t)}; }

bool RigidTransform::finite() const { return R.allFinite() && t.allFinite(); }

bool RigidTransform::is_rigid() const {
  return finite() && (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= 1e-3;
}

RigidTransform operator*(const RigidTransform& T_a_b, const RigidTransform& T_b_c) {
  return {T_a_b.R * T_b_c.R, T_a_b.R * T_b_c.t + T_a_b.t};
}

bool operator==(const RigidTransform& a, const RigidTransform& b) { return a.R == b.R && a.t == b.t; }

Eigen::Matrix3d rotation(const Eigen::Vector3d& axis_angle) {
  const double angle = axis_angle.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, axis_angle / angle).toRotationMatrix()
                   : Eigen::Matrix3d::Identity();
}

Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0).finished();
}

RigidTransform transform_of(const PoseMatrix& rows) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> m(rows.data());
  return {m.leftCols<3>(), m.col(3)};
}

PoseMatrix pose_matrix_of(const RigidTransform& T) {
  PoseMatrix rows{};
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> m(rows.data());
  m.leftCols<3>() = T.R;
  m.col(3) = T.t;
  return rows;
}

}  // namespace hdrcam
