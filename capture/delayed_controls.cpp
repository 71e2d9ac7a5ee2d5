#include "capture/delayed_controls.h"

#include <algorithm>

namespace hdrcam {

DelayedControls::DelayedControls(const SensorDelays& delays, const ExposureRequest& now,
                                 Duration frame_duration)
    : delays_(delays), before_{now, frame_duration} {
  HDRCAM_CHECK(std::min({delays.exposure, delays.gain, delays.vblank}) >= 0);
  HDRCAM_CHECK_LT(delays.most(), kHistory / 2);
  ring_[0] = before_;
}

void DelayedControls::push(const ExposureRequest& request, Duration frame_duration) {
  entry(write_count_) = {request, frame_duration};
}

DelayedControls::Writes DelayedControls::frame_started(std::uint64_t sequence) {
  // A fast control is written later than the slowest by the difference of their delays:
  // libcamera's DelayedControls::applyControls.
  const auto due = [&](int delay) -> const Entry& {
    const auto held_back = static_cast<std::uint64_t>(delays_.most() - delay);
    return write_count_ < held_back ? before_ : entry(write_count_ - held_back);
  };
  const Writes writes{due(delays_.exposure).request.exposure, due(delays_.gain).request.analogue_gain,
                      due(delays_.vblank).frame_duration};
  // A jump longer than the history keeps only the last request.
  if (sequence > write_count_ + kHistory) {
    const Entry last = entry(write_count_);
    ring_.fill(last);
    write_count_ = sequence;
  }
  while (write_count_ <= sequence) {
    const Entry last = entry(write_count_);
    entry(++write_count_) = last;
  }
  return writes;
}

std::optional<DelayedControls::Latched> DelayedControls::shown_by(std::uint64_t sequence) const {
  const auto most = static_cast<std::uint64_t>(delays_.most());
  const std::uint64_t index = sequence - std::min(sequence, most);
  if (index > write_count_ || write_count_ - index >= kHistory) return std::nullopt;
  const ExposureRequest& request = (sequence < most ? before_ : entry(index)).request;
  return Latched{request.cookie, request.exposure, request.analogue_gain};
}

}  // namespace hdrcam
