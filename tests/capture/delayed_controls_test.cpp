#include "capture/delayed_controls.h"

#include <catch2/catch.hpp>
#include <vector>

namespace hdrcam {
namespace {

// A sensor's registers: a value written as frame s begins shows from frame s + delay on.
class Registers {
 public:
  Registers(const ControlDelays& delays, const ExposureRequest& now) : delays_(delays), frames_(100, now) {}
  void write(std::size_t frame, const ExposureRequest& written) {
    for (std::size_t i = frame + static_cast<std::size_t>(delays_.exposure); i < frames_.size(); ++i)
      frames_[i].exposure = written.exposure;
    for (std::size_t i = frame + static_cast<std::size_t>(delays_.gain); i < frames_.size(); ++i)
      frames_[i].analogue_gain = written.analogue_gain;
  }
  bool shows(std::size_t frame, const ExposureRequest& wanted) const {
    return frames_[frame].exposure == wanted.exposure && frames_[frame].analogue_gain == wanted.analogue_gain;
  }

 private:
  ControlDelays delays_;
  std::vector<ExposureRequest> frames_;
};

ExposureRequest request(std::uint64_t cookie) {
  return {cookie, Duration(static_cast<Duration::rep>(1000 * (cookie + 1))),
          1 + 0.01 * static_cast<double>(cookie)};
}

TEST_CASE("for every pair of delays each frame shows both controls of one request, the longer delay after it",
          "[capture]") {
  constexpr ExposureRequest kNow{0, Duration(77), 5};
  for (int exposure = 0; exposure <= kMaxDelay; ++exposure)
    for (int gain = 0; gain <= kMaxDelay; ++gain) {
      CAPTURE(exposure, gain);
      const auto most = static_cast<std::uint64_t>(std::max(exposure, gain));
      DelayedControls controls({exposure, gain}, kNow);
      Registers sensor({exposure, gain}, kNow);
      for (std::uint64_t frame = 0; frame < 60; ++frame) {
        const ExposureRequest written = controls.held_back(request(frame));
        REQUIRE(written.cookie == frame);
        sensor.write(frame, written);
        REQUIRE(sensor.shows(frame, frame < most ? kNow : request(frame - most)));
      }
    }
}

}  // namespace
}  // namespace hdrcam
