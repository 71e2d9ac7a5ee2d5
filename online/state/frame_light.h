// How much light a frame has beside the state. Lamps on the mains flicker a hundred times a second, and a
// short exposure sees a moment of that: one frame is brighter than its exposure says, another darker. Each
// frame is compared with the state along its motion. Where frames of one exposure keep differing, light
// counts as exposure: the frame's own, but for what goes on, which the state follows as light that changes.
// Steady light, and light that changes once, is left as it is. Thread-bound; no allocation after the first
// frame.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "online/state/state_comparison.h"

namespace hdrcam {

class FrameLight {
 public:
  // The light is known to be unsteady, until frames show that it is no longer.
  void expect_unsteady() { unsteady_ = expected_ = true; }

  // ln of the factor that the frame's exposure gets; 0 while light is steady, or where the frame does not
  // tell. The frame and the state of the frame before it, as stated; the motion need not be rated.
  float follow(const StateComparison& seen);

  bool unsteady() const { return unsteady_; }
  // Of the factors so far, in stops: their root mean square; 0 where light was steady.
  double spread_stops() const;

 private:
  static constexpr std::size_t kRemembered = 16;  // frames: four rounds of the longest cycle
  struct Light {
    float log_exposure = 0;  // as stated
    float beyond = 0;        // ln of the frame's light over the state's
  };

  std::optional<float> beyond_state(const StateComparison& seen);
  void remember(const Light& light);
  std::size_t remembered() const { return std::min(count_, kRemembered); }
  const Light& before(std::size_t age) const;  // 0: the newest
  float apart(const Light& light) const;
  // How far frames differ from others of their exposure: the mean, over that third of the remembered ones
  // where it is least, for what happens once is in two of them at most.
  float unsteadiness() const;

  std::array<Light, kRemembered> recent_;
  std::size_t count_ = 0;  // so far
  bool unsteady_ = false, expected_ = false;
  float goes_on_ = 0;  // ln: what all frames have beyond the state
  double squares_ = 0;
  long followed_ = 0;
  std::vector<float> ratios_;
};

}  // namespace hdrcam
