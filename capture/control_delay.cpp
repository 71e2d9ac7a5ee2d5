#include "capture/control_delay.h"

#include <algorithm>

namespace hdrcam {
namespace {

struct SensorRow {
  std::string_view name;
  KnownSensor sensor;
};

constexpr SensorRow kSensors[] = {
    {"imx219", {{2, 1, 2}, BlackLevel::of_code(64, 10)}},
    {"imx283", {{2, 1, 2}, BlackLevel::of_code(50, 10)}},
    {"imx290", {{2, 2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx296", {{2, 2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx462", {{2, 2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx477", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"imx500", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"imx519", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"imx708", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"ov5647", {{2, 2, 2}, BlackLevel::of_code(16, 10)}},
    {"ov7251", {{2, 2, 2}, BlackLevel::of_code(64, 10)}},
    {"ov9281", {{2, 2, 2}, BlackLevel::of_code(64, 10)}},
};

}  // namespace

std::optional<KnownSensor> known_sensor(std::string_view model) {
  const auto row = std::find_if(std::begin(kSensors), std::end(kSensors), [&](const SensorRow& r) {
    return model.find(r.name) != std::string_view::npos;
  });
  if (row == std::end(kSensors)) return std::nullopt;
  return row->sensor;
}

ControlDelay::ControlDelay(const SensorDelays& delays, const ExposureRequest& now, Duration frame_duration)
    : delays_(delays), before_{now, frame_duration} {
  HDRCAM_CHECK(std::min({delays.exposure, delays.gain, delays.vblank}) >= 0);
  HDRCAM_CHECK_LT(delays.most(), kHistory / 2);
  ring_[0] = before_;
}

void ControlDelay::push(const ExposureRequest& request, Duration frame_duration) {
  entry(write_count_) = {request, frame_duration};
}

ControlDelay::Writes ControlDelay::frame_started(std::uint64_t sequence) {
  // A fast control is written later than the slowest by the difference of their delays:
  // DelayedControls::applyControls.
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

std::optional<ControlDelay::Latched> ControlDelay::shown_by(std::uint64_t sequence) const {
  const auto most = static_cast<std::uint64_t>(delays_.most());
  const std::uint64_t index = sequence - std::min(sequence, most);
  if (index > write_count_ || write_count_ - index >= kHistory) return std::nullopt;
  const ExposureRequest& request = (sequence < most ? before_ : entry(index)).request;
  return Latched{request.cookie, request.exposure, request.analogue_gain};
}

}  // namespace hdrcam
