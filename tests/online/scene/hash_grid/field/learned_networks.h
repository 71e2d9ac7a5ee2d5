// A small field for a window of a few frames, far from its start as after learning: nearly all of its
// gradients differ from zero. Deterministic.
#pragma once

#include "online/scene/hash_grid/field/field.h"
#include "online/scene/hash_grid/field/random.h"

namespace hdrcam {

inline FieldShape learned_shape(Blend blend, int frames) {
  FieldShape shape;
  shape.static_grid = {4, 8, 1, 4, 16, 0.75f, 0.5f};
  shape.dynamic_grid = {2, 8, frames + 1, 4, 12, 0.75f, 0.5f};
  shape.hidden = 12;
  shape.blend = blend;
  return shape;
}

inline FieldNetworks<float> learned_networks(Blend blend, int frames) {
  Pcg32 random(3);
  FieldNetworks<float> networks(learned_shape(blend, frames), random);
  for (auto* branch : {&networks.static_, &networks.dynamic}) {
    for (float& value : branch->grid.tables().samples()) value *= 60;
    for (float& value : branch->mlp.parameters()) value = 2 * value + random.uniform(-0.1f, 0.1f);
  }
  return networks;
}

}  // namespace hdrcam
