// Window space and the cameras that look into it. Window space is the anchor camera's frustum, widened by a
// margin for its neighbours' views: u, v across the widened picture and d along inverse depth, all in [0, 1].
// A camera is given by its transform to the anchor. Inverse depth q is near / z, dimensionless, 0 at infinity
// and 1 at the near plane; where poses are unknown all cameras coincide with the anchor, and depth only
// orders the surfaces. Scalar type T as in field/hash_grid.h. Value types, reentrant.
#pragma once

#include <algorithm>

#include "hal/core/frame.h"
#include "hal/core/geometry.h"
#include "online/scene/hash_grid/field/view_constants.h"

namespace hdrcam {

struct WindowFrustum {
  Intrinsics camera;
  int rows = 0, cols = 0;  // of the picture
  float margin = 1.25f;    // width of the window over the width of the picture
  float near = 1;          // distance of the near plane, in the poses' unit
  int step_px = 1;         // 1, 2, 4, 8: a pixel here is a block of step_px x step_px of the stream's

  // One pixel of the anchor's picture, in window units along u and v; the unit of flow along d is kDepthUnit.
  double u_per_px() const { return 1 / (static_cast<double>(cols) * static_cast<double>(margin)); }
  double v_per_px() const { return 1 / (static_cast<double>(rows) * static_cast<double>(margin)); }
  static constexpr double kDepthUnit = 0.01;
};

// Window units per unit of flow, along u, v, d.
template <class T>
void flow_units(const WindowFrustum& frustum, T* unit) {
  unit[0] = T(frustum.u_per_px()), unit[1] = T(frustum.v_per_px());
  unit[2] = T(WindowFrustum::kDepthUnit);
}

template <class T>
class ViewGeometry {
 public:
  ViewGeometry(const WindowFrustum& frustum, const RigidTransform& T_anchor_camera)
      : focal_{T(frustum.camera.fx_px), T(frustum.camera.fy_px)},
        centre_{T(frustum.camera.cx_px), T(frustum.camera.cy_px)},
        size_{T(frustum.cols), T(frustum.rows)},
        margin_(frustum.margin) {
    const RigidTransform T_camera_anchor = T_anchor_camera.inverse();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        to_anchor_[i][j] = T(T_anchor_camera.R(i, j));
        from_anchor_[i][j] = T(T_camera_anchor.R(i, j));
      }
      to_anchor_[i][3] = T(T_anchor_camera.t(i) / frustum.near);
      from_anchor_[i][3] = T(T_camera_anchor.t(i) / frustum.near);
    }
  }

  // window point of a pixel at inverse depth q; may lie outside the unit cube
  void place(const T pixel[2], T q, T x[3]) const {
    const T ray[3] = {(pixel[0] - centre_[0]) / focal_[0], (pixel[1] - centre_[1]) / focal_[1], 1};
    T p[3];
    for (int i = 0; i < 3; ++i)
      p[i] = to_anchor_[i][0] * ray[0] + to_anchor_[i][1] * ray[1] + to_anchor_[i][2] + to_anchor_[i][3] * q;
    const T z = std::max(p[2], kNearest);
    for (int i = 0; i < 2; ++i)
      x[i] = ((focal_[i] * p[i] / z + centre_[i]) / size_[i] - T(0.5)) / margin_ + T(0.5);
    x[2] = kDepthOffset + kDepthScale * q / z;
  }

  // projects a window point: pixel x, y and inverse depth; jacobian [3][3] = d seen / d x, may be null
  void project(const T x[3], T seen[3], T (*jacobian)[3]) const {
    T ray[3] = {0, 0, 1};
    for (int i = 0; i < 2; ++i)
      ray[i] = (((x[i] - T(0.5)) * margin_ + T(0.5)) * size_[i] - centre_[i]) / focal_[i];
    const T q = inverse_depth(x[2]);
    T p[3];
    for (int i = 0; i < 3; ++i)
      p[i] = from_anchor_[i][0] * ray[0] + from_anchor_[i][1] * ray[1] + from_anchor_[i][2] +
             from_anchor_[i][3] * q;
    const bool behind = p[2] < kNearest;
    const T z = behind ? kNearest : p[2];
    for (int i = 0; i < 2; ++i) seen[i] = focal_[i] * p[i] / z + centre_[i];
    seen[2] = q / z;
    if (jacobian == nullptr) return;
    const T ray_per_x[3] = {margin_ * size_[0] / focal_[0], margin_ * size_[1] / focal_[1], 1 / kDepthScale};
    constexpr int kColumn[3] = {0, 1, 3};
    for (int j = 0; j < 3; ++j) {
      const int column = kColumn[j];
      const T d_z = behind ? T(0) : from_anchor_[2][column];
      for (int i = 0; i < 2; ++i)
        jacobian[i][j] = focal_[i] / z * (from_anchor_[i][column] - p[i] / z * d_z) * ray_per_x[j];
      jacobian[2][j] = ((j == 2 ? T(1) : T(0)) - q / z * d_z) / z * ray_per_x[j];
    }
  }

  // rows of [R | t / near] to the anchor
  const T (&to_anchor() const)[3][4] { return to_anchor_; }
  // of a window coordinate d, as the anchor sees it
  static T inverse_depth(T d) { return (d - kDepthOffset) / kDepthScale; }

  // z over the near distance, at least
  static constexpr T kNearest = T(view_constants::kNearest);

 private:
  static constexpr T kDepthOffset = T(view_constants::kDepthOffset),
                     kDepthScale = T(view_constants::kDepthScale);
  T focal_[2], centre_[2], size_[2], margin_;
  T to_anchor_[3][4], from_anchor_[3][4];  // translation over the near distance
};

}  // namespace hdrcam
