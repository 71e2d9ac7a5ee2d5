// Pulls occlusion weights towards 1 (visible): without this term the cheapest solution marks everything as
// occluded (as in NSFF's published code). visible: the ray's rendered occlusion weight 0..1. Reentrant.
#pragma once

namespace hdrcam {

template <class T>
T occlusion_loss(T weight, T visible, T& d_visible) {
  d_visible -= weight;
  return weight * (1 - visible);
}

}  // namespace hdrcam
