#include "capture/order_check.h"

#include <algorithm>
#include <cmath>

#include "capture/exposure.h"

namespace hdrcam {
namespace {

// The pictures clearly go up where the exposures go down, or the reverse. Of neighbours that have nothing in
// common little more than the sign is sure.
bool goes_against(const CycleStep& step, double log_ratio) {
  constexpr double kClearlySeen = 0.3, kClearlySaid = 0.5;
  return step.log_ratio * log_ratio < 0 && std::abs(step.log_ratio) > kClearlySeen &&
         std::abs(log_ratio) > kClearlySaid;
}

}  // namespace

bool OrderCheck::add(double from, double to, const CycleStep& step) {
  const bool against = goes_against(step, to - from);
  auto found = std::ranges::find_if(transitions_, [&](const Transition& seen) {
    return same_exposure(seen.from, from) && same_exposure(seen.to, to);
  });
  if (found == transitions_.end()) {
    if (transitions_.size() == kMost) return against;
    transitions_.push_back({from, to});
    found = transitions_.end() - 1;
  }
  ++found->steps, found->against += against;
  return against;
}

bool OrderCheck::objects() const {
  return std::ranges::any_of(transitions_, [&](const Transition& seen) {
    return seen.against >= least_ && 2 * seen.against > seen.steps;
  });
}

}  // namespace hdrcam
