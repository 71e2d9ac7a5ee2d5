// Scene flow cycle consistency (paper appendix, L_cyc): w |f_{i->j}(x) + f_{j->i}(x + f_{i->j}(x))|, flow in
// pixels of the anchor, w the sample's occlusion weight. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

// there, back: flow[3]. Adds to d_there[3], d_back[3] and d_visible.
template <class T>
T cycle_loss(T weight, const T* there, const T* back, T visible, T* d_there, T* d_back, T& d_visible) {
  constexpr T kSoftness_px = T(0.1);
  T loss = 0;
  for (int a = 0; a < 3; ++a) {
    const auto rho = robust(there[a] + back[a], kSoftness_px);
    loss += weight * rho.value;
    d_there[a] += weight * visible * rho.slope;
    d_back[a] += weight * visible * rho.slope;
  }
  d_visible += loss;
  return visible * loss;
}

}  // namespace hdrcam
