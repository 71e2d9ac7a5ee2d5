#include "render/surface_points.h"

namespace hdrcam {
namespace {

// d^2 / (d^2 + sigma_d^2) of a depth that is known to a tenth
constexpr float kLeastWeight = 1 / (1 + 0.1f * 0.1f);

}  // namespace

void find_surface_points(const FrameEstimate& estimate, const Image<float>& radiance,
                         std::vector<SurfacePoint>& points) {
  points.clear();
  if (!estimate.pose || estimate.pose->lost || estimate.depth == nullptr || estimate.depth->empty()) return;
  const DepthMap& map = *estimate.depth;
  const Intrinsics& lens = estimate.view.lens;
  const RigidTransform& T_world_camera = estimate.pose->T_world_camera;
  const int stride = std::max(1, kSurfacePointStep_px / map.step_px);  // in the map
  for (int row = stride / 2; row < map.weight.rows(); row += stride)
    for (int col = stride / 2; col < map.weight.cols(); col += stride) {
      const float inverse_depth = map.inverse_depth.at(0, row, col);
      const int y = map.pixel_of(row, radiance.rows()), x = map.pixel_of(col, radiance.cols());
      if (map.weight.at(0, row, col) < kLeastWeight || inverse_depth <= 0) continue;
      const double z = 1 / static_cast<double>(inverse_depth), u = x + 0.5, v = y + 0.5;
      const Eigen::Vector3d p_camera{(u - lens.cx_px) / lens.fx_px * z, (v - lens.cy_px) / lens.fy_px * z, z};
      points.push_back({T_world_camera.R * p_camera + T_world_camera.t,
                        u,
                        v,
                        {radiance.at(0, y, x), radiance.at(1, y, x), radiance.at(2, y, x)}});
    }
}

}  // namespace hdrcam
