#include "render/time_code.h"

#include <chrono>

#include <catch2/catch.hpp>

namespace hdrcam {

TEST_CASE("a time code counts frames, carries into seconds and wraps at midnight") {
  const auto at_frame = [](int n, double hz) { return time_code(from_seconds(n / hz), hz); };
  REQUIRE(at_frame(0, 30) == TimeCode{0, 0, 0, 0});
  for (int n = 0; n < 30; ++n) REQUIRE(at_frame(n, 30) == TimeCode{0, 0, 0, n});
  REQUIRE(at_frame(30 * 3671 + 7, 30) == TimeCode{1, 1, 11, 7});
  REQUIRE(at_frame(25 * 86400 + 3, 25) == TimeCode{0, 0, 0, 3});
  REQUIRE(at_frame(59, 60) == TimeCode{0, 0, 0, 29});  // pairs of frames above 30 Hz
}

TEST_CASE("frames whose times tremble, or are whole milliseconds, keep their own time codes") {
  using namespace std::chrono_literals;
  for (const int hz : {24, 25, 30}) {
    for (int n = 1; n < 3 * hz; ++n) {
      const Duration time = from_seconds(n / static_cast<double>(hz));
      const TimeCode wanted{0, 0, n / hz, n % hz};
      INFO(hz << " Hz, frame " << n);
      REQUIRE(time_code(std::chrono::round<std::chrono::milliseconds>(time), hz) == wanted);
      REQUIRE(time_code(time - 3us, hz) == wanted);
      REQUIRE(time_code(time + 3us, hz) == wanted);
    }
  }
  REQUIRE(time_code(999'999'700ns, 25) == TimeCode{0, 0, 1, 0});  // no frame 25 of a second of 25
  REQUIRE(time_code(10s, 0.1) == TimeCode{0, 0, 10, 0});          // slower than seconds
}

TEST_CASE("a camera whose interval is a rounded thirtieth of a second counts its frames, not pairs of them") {
  using namespace std::chrono_literals;
  for (const Duration interval : {Duration(33'333'333ns), Duration(33'333us)})
    for (int n = 0; n < 90; ++n)
      REQUIRE(time_code(n * interval, 1 / to_seconds(interval)) == TimeCode{0, 0, n / 30, n % 30});
  for (const Duration interval : {Duration(16'666'667ns), Duration(16'666us)})
    for (int n = 0; n < 180; ++n)
      REQUIRE(time_code(n * interval, 1 / to_seconds(interval)) == TimeCode{0, 0, n / 60, n % 60 / 2});
}

TEST_CASE("a camera of 30 / 1.001 Hz counts thirty frames in each of its seconds, one of 24 / 1.001 Hz 24") {
  for (const int hz : {24, 30, 60, 120}) {
    const int frames_of_code = hz > 30 ? hz / 30 : 1;
    for (const int n : {0, 1, 999 * hz, 3599 * hz + 7}) {
      for (int frame = n; frame < n + 40 * hz; ++frame) {
        const int second = frame / hz, count = frame % hz / frames_of_code;
        const Duration time = from_seconds(frame * 1.001 / hz);
        const TimeCode wanted{second / 3600, second / 60 % 60, second % 60, count};
        INFO(hz << " / 1.001 Hz, frame " << frame);
        REQUIRE(time_code(time, hz / 1.001) == wanted);
        if (hz <= 30)
          REQUIRE(time_code(std::chrono::round<std::chrono::milliseconds>(time), hz / 1.001) == wanted);
      }
    }
  }
  // an interval of whole microseconds
  REQUIRE(time_code(from_seconds(29 * 0.033367), 1 / 0.033367) == TimeCode{0, 0, 0, 29});
  REQUIRE(time_code(from_seconds(30 * 0.033367), 1 / 0.033367) == TimeCode{0, 0, 1, 0});
  // what is only near such a rate goes by the clock
  REQUIRE(time_code(from_seconds(1), 29.9) == TimeCode{0, 0, 1, 0});
}

}  // namespace hdrcam
