// Response smoothness (paper appendix, L_smooth): squared second differences of the curve's points. Its
// weight belongs to LearnedResponse's number of points: the integral of g''^2 would take their cube, not the
// square. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/learned_response.h"

namespace hdrcam {

template <class T>
T response_smoothness_loss(T weight, const LearnedResponse<T>& response,
                           typename LearnedResponse<T>::Gradient& d_point) {
  constexpr int kLast = LearnedResponse<T>::kPoints - 1;
  const T scale = weight * T(kLast) * T(kLast);
  T loss = 0;
  for (int c = 0; c < 3; ++c)
    for (int j = 1; j < kLast; ++j) {
      const T bend = response.point(c, j - 1) - 2 * response.point(c, j) + response.point(c, j + 1);
      loss += scale * bend * bend;
      auto& d = d_point[static_cast<std::size_t>(c)];
      const auto at = static_cast<std::size_t>(j);
      d[at - 1] += 2 * scale * bend;
      d[at] -= 4 * scale * bend;
      d[at + 1] += 2 * scale * bend;
    }
  return loss;
}

}  // namespace hdrcam
