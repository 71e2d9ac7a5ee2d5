#include "online/pending_frames.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

ExposedFrame frame_at(double seconds) {
  ExposedFrame frame;
  frame.facts.timestamp = Instant::from_seconds(seconds);
  frame.codes.reshape(3, 2, 2);
  return frame;
}

void add(PendingFrames& frames, double seconds) {
  ExposedFrame frame = frame_at(seconds);
  frames.add(frame).emitted = true;
}

}  // namespace

TEST_CASE("emitted frames go but for the newest, and the intervals before them stay known") {
  WorkerPool pool(1);
  PendingFrames frames(pool);
  add(frames, 1.0);
  CHECK(frames.before_ratio(0) == 1);
  add(frames, 1.1);
  CHECK(frames.before_ratio(1) == 1);
  add(frames, 1.3);
  add(frames, 1.4);
  CHECK(frames.before_ratio(2) == Approx(2));
  CHECK(frames.before_ratio(3) == Approx(0.5));
  CHECK(frames.after_ratio(2) == Approx(0.2 / 0.3));

  frames.retire_emitted();
  REQUIRE(frames.size() == 1);
  CHECK(frames.before_ratio(0) == Approx(0.5));
  frames.retire_all();
  CHECK(frames.empty());
  add(frames, 1.5);
  CHECK(frames.before_ratio(0) == Approx(1));
}

TEST_CASE("a frame that waits holds back those behind it") {
  WorkerPool pool(1);
  PendingFrames frames(pool);
  add(frames, 1.0), add(frames, 1.1), add(frames, 1.2);
  frames[0].emitted = false;
  frames.retire_emitted();
  CHECK(frames.size() == 3);
}

TEST_CASE("time stamps that stand still or run backward count as even intervals, and jumps are bounded") {
  WorkerPool pool(1);
  PendingFrames frames(pool);
  for (const double seconds : {1.0, 1.1, 1.1, 1.05, 1.06, 9.0}) add(frames, seconds);
  CHECK(frames.before_ratio(2) == 1);
  CHECK(frames.before_ratio(3) == 1);
  CHECK(frames.before_ratio(4) == 1);
  CHECK(frames.before_ratio(5) == 10);
  // of two intervals the first is never all or nothing
  CHECK(frames.after_ratio(1) == Approx(0.9));
  CHECK(frames.after_ratio(2) == Approx(0.5));
  CHECK(frames.after_ratio(4) == Approx(0.1));
}

TEST_CASE("a state that is kept is the frame's own, and is given back with the frame") {
  WorkerPool pool(1);
  PendingFrames frames(pool);
  add(frames, 1.0), add(frames, 1.1);
  RadianceState state;
  state.radiance.reshape(3, 2, 2), state.variance.reshape(3, 2, 2), state.own_share.reshape(1, 2, 2);
  state.radiance.at(1, 1, 0) = 0.25f;
  frames.keep_state(0, state);
  state.radiance.at(1, 1, 0) = 1;
  CHECK(frames[0].state.radiance.at(1, 1, 0) == 0.25f);

  frames.retire_emitted();
  add(frames, 1.2);
  CHECK(frames[1].state.radiance.empty());
}
