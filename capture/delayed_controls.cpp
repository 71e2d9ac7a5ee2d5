#include "capture/delayed_controls.h"

#include <algorithm>

namespace hdrcam {

DelayedControls::DelayedControls(const ControlDelays& delays, const ExposureRequest& now) : now_(now) {
  const auto [least, most] = std::minmax(delays.exposure, delays.gain);
  HDRCAM_CHECK(least >= 0);
  HDRCAM_CHECK_LE(most, kMaxDelay);
  held_ = {most - delays.exposure, most - delays.gain};
}

ExposureRequest DelayedControls::held_back(const ExposureRequest& request) {
  requests_[count_++ % requests_.size()] = request;
  return {request.cookie, before(held_.exposure).exposure, before(held_.gain).analogue_gain};
}

// The request that came so many before the newest one.
const ExposureRequest& DelayedControls::before(int requests) const {
  const auto back = static_cast<std::uint64_t>(requests);
  return count_ > back ? requests_[(count_ - 1 - back) % requests_.size()] : now_;
}

}  // namespace hdrcam
