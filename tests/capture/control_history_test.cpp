// Requests and the frames that completed them, by hand: which controls were written when a frame began.
#include "capture/control_history.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

// Requests are queued in order; the cookie is the exposure in milliseconds.
struct Camera {
  void queue(int requests) {
    for (int i = 0; i < requests; ++i, ++next_cookie) history.sent({next_cookie, next_cookie * 1ms, 1}, 0);
  }
  // -1: unknown.
  int written_at(std::int64_t frame) const {
    const ControlHistory::Request* request = history.written_at(frame);
    return request == nullptr ? -1 : static_cast<int>(request->controls.exposure / 1ms);
  }

  ControlHistory history;
  std::uint64_t next_cookie = 0;
};

TEST_CASE("a request is due from the frame after the one before until the frame that completes it",
          "[capture]") {
  Camera camera;
  camera.queue(8);
  CHECK(camera.history.completed(0, 0, false));
  CHECK(camera.history.completed(4, 1, false));  // frames 1 to 3 were lost
  CHECK(camera.history.completed(5, 2, true));
  const int want[] = {0, 1, 1, 1, 1, 2};
  for (int frame = 0; frame < 6; ++frame) CHECK(camera.written_at(frame) == want[frame]);
  CHECK(camera.written_at(-1) == -1);
  CHECK(camera.history.written_at(5)->late);
  CHECK_FALSE(camera.history.written_at(4)->late);
}

TEST_CASE("frames that were lost before their request was queued keep the controls before it", "[capture]") {
  Camera camera;
  camera.queue(8);
  CHECK_FALSE(camera.history.queued_at(2).has_value());
  camera.history.queued(2, Instant::from_seconds(5));
  CHECK(camera.history.queued_at(2) == Instant::from_seconds(5));
  CHECK_FALSE(camera.history.queued_at(2 + ControlHistory::kRequests).has_value());
  CHECK(camera.history.completed(0, 0, false));
  CHECK(camera.history.completed(1, 1, false));
  CHECK(camera.history.completed(6, 2, false, {2, 2}));  // 2 to 5 were lost, it was queued before 5
  CHECK(camera.history.completed(8, 3, false));          // 7 was lost, it had been queued for long
  const int want[] = {0, 1, 1, 1, 1, 2, 2, 3, 3};
  for (int frame = 0; frame < 9; ++frame) CHECK(camera.written_at(frame) == want[frame]);
  CHECK(camera.history.completed(100, 4, false, {1, 1}));  // more were lost than are kept
  CHECK(camera.written_at(99) == 3);
  CHECK(camera.written_at(100) == 4);
  CHECK(camera.history.completed(104, 5, false, {1, 3}));  // it was queued about when 102 or 103 began
  CHECK(camera.written_at(101) == 4);
  CHECK(camera.written_at(102) == -1);
  CHECK(camera.written_at(103) == -1);
  CHECK(camera.written_at(104) == 5);
}

TEST_CASE("frames to come show the queued requests in turn, and nothing that is not queued yet",
          "[capture]") {
  Camera camera;
  camera.queue(4);
  CHECK(camera.history.completed(0, 0, false));
  for (int frame = 1; frame < 4; ++frame) CHECK(camera.written_at(frame) == frame);
  CHECK(camera.written_at(4) == -1);
}

TEST_CASE("what was written for a frame whose request came twice is unknown", "[capture]") {
  Camera camera;
  camera.queue(8);
  CHECK(camera.history.completed(0, 0, false));
  CHECK(camera.history.completed(1, 1, false));
  CHECK_FALSE(camera.history.completed(2, 1, false));
  CHECK(camera.history.completed(3, 3, false));
  CHECK(camera.written_at(1) == 1);
  CHECK(camera.written_at(2) == -1);
  CHECK(camera.written_at(3) == 3);
}

TEST_CASE("frames and requests that are too old are unknown, never taken for later ones", "[capture]") {
  Camera camera;
  for (std::uint64_t frame = 0; frame < 100; ++frame) {
    camera.queue(1);
    CHECK(camera.history.completed(frame, frame, false));
  }
  for (int frame = 0; frame < 100; ++frame)
    CHECK(camera.written_at(frame) == (frame > 99 - ControlHistory::kFrames ? frame : -1));
  camera.queue(ControlHistory::kRequests - 10);  // queued ahead, over all but the last ten
  for (int frame = 0; frame < 100; ++frame) CHECK(camera.written_at(frame) == (frame >= 90 ? frame : -1));
}

}  // namespace
}  // namespace hdrcam
