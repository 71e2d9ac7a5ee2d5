#include "render/views/keyframe_maker.h"

#include "hal/core/median.h"
#include "online/mu_law.h"

namespace hdrcam {

void KeyframeMaker::complete(const SnapshotHold& field, const Keyframe* before, Keyframe& key) {
  take_depth(field, key);
  edges_.follow(key.frame.radiance, barely_visible(key.frame.white), key.inverse_depth);
  if (before != nullptr) motion_.match(*before, key);
}

void KeyframeMaker::take_depth(const SnapshotHold& field, Keyframe& key) {
  const int rows = key.frame.radiance.rows(), cols = key.frame.radiance.cols();
  key.inverse_depth.reshape(1, rows, cols);
  if (!field) {
    key.inverse_depth.fill(1), key.knows_depth = false;
    return;
  }
  field->look({.T_world_camera = key.T_world_camera,
               .time_s = key.time_s,
               .lens = key.lens,
               .rows = rows,
               .cols = cols},
              pool_, own_view_);
  if (!key.knows_depth) {
    key.inverse_depth.fill(1 / (median(own_view_.depth.samples()) * key.depth_unit));
    return;
  }
  for (std::size_t i = 0; i < key.inverse_depth.size(); ++i)
    key.inverse_depth.samples()[i] = 1 / (own_view_.depth.samples()[i] * key.depth_unit);
}

}  // namespace hdrcam
