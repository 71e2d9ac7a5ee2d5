#include "capture/delayed_controls.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

namespace hdrcam {
namespace {

constexpr Duration kFrame{33'333'333};

// A sensor's registers: a value written as frame s begins shows from frame s + delay on.
class Registers {
 public:
  explicit Registers(const SensorDelays& delays, const ExposureRequest& now)
      : delays_(delays), frames_(1000, now) {}
  void write(std::size_t frame, const DelayedControls::Writes& writes) {
    for (std::size_t i = frame + static_cast<std::size_t>(delays_.exposure); i < frames_.size(); ++i)
      frames_[i].exposure = writes.exposure;
    for (std::size_t i = frame + static_cast<std::size_t>(delays_.gain); i < frames_.size(); ++i)
      frames_[i].analogue_gain = writes.analogue_gain;
  }
  bool shows(std::size_t frame, const DelayedControls::Latched& latched) const {
    return frames_[frame].exposure == latched.exposure &&
           frames_[frame].analogue_gain == latched.analogue_gain;
  }

 private:
  SensorDelays delays_;
  std::vector<ExposureRequest> frames_;
};

ExposureRequest request(std::uint64_t cookie) {
  return {cookie, Duration(static_cast<Duration::rep>(1000 * (cookie + 1))),
          1 + 0.01 * static_cast<double>(cookie)};
}

TEST_CASE("for every set of delays the twin agrees with the sensor, cookie included", "[capture]") {
  std::mt19937 random(7);
  for (int exposure = 0; exposure <= 4; ++exposure) {
    for (int gain = 0; gain <= 4; ++gain) {
      for (int vblank = 0; vblank <= 4; ++vblank) {
        const SensorDelays delays{exposure, gain, vblank};
        DelayedControls twin(delays, request(0), kFrame);
        Registers sensor(delays, request(0));
        std::vector<std::uint64_t> pushed(1, 0);
        for (std::uint64_t frame = 0; frame < 60; ++frame) {
          if (random() % 4 != 0) {  // now and then nobody asks for anything: the last request is repeated
            twin.push(request(frame + 1), kFrame);
            pushed.push_back(frame + 1);
          } else {
            pushed.push_back(pushed.back());
          }
          sensor.write(frame, twin.frame_started(frame));
          const auto latched = twin.shown_by(frame);
          REQUIRE(latched);
          REQUIRE(sensor.shows(frame, *latched));
          const auto most = static_cast<std::uint64_t>(delays.most());
          REQUIRE(latched->cookie == (frame < most ? 0 : pushed[frame - most + 1]));
        }
      }
    }
  }
}

TEST_CASE("after a frame start that it missed, the twin disagrees with the sensor and then agrees again",
          "[capture]") {
  for (int exposure = 0; exposure <= 3; ++exposure) {
    for (int gain = 0; gain <= 3; ++gain) {
      const SensorDelays delays{exposure, gain, 0};
      DelayedControls twin(delays, request(0), kFrame);
      Registers sensor(delays, request(0));
      std::uint64_t first = 0, last = 0;
      for (std::uint64_t frame = 0; frame < 40; ++frame) {
        twin.push(request(frame + 1), kFrame);
        if (frame != 20) sensor.write(frame, twin.frame_started(frame));
        const auto latched = twin.shown_by(frame);
        if (latched && !sensor.shows(frame, *latched)) {
          if (first == 0) first = frame;
          last = frame;
        }
      }
      CAPTURE(exposure, gain);
      CHECK(first >= 20);
      CHECK(last >= first);
      CHECK(last <= 21 + static_cast<std::uint64_t>(delays.most()));
    }
  }
}

TEST_CASE("the twin remembers a while, and says when it does not", "[capture]") {
  DelayedControls twin({2, 1, 2}, request(0), kFrame);
  for (std::uint64_t frame = 0; frame < 100; ++frame) {
    twin.push(request(frame + 1), kFrame);
    twin.frame_started(frame);
  }
  CHECK(twin.shown_by(99)->cookie == 98);
  CHECK(twin.shown_by(80)->cookie == 79);
  CHECK_FALSE(twin.shown_by(60));
  CHECK_FALSE(twin.shown_by(110));
  // A counter that jumps leaves only the last request.
  twin.frame_started(100'000);
  CHECK(twin.shown_by(100'000)->cookie == 100);
}

}  // namespace
}  // namespace hdrcam
