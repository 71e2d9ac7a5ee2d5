// The frames from their arrival to their emission, the oldest first, each with what is known of it so far: a
// frame waits for its look-ahead while the state goes on to later ones. The newest stays after its emission
// too, because the next frame is compared with it. Frames are used again, and their pictures of full size
// borrowed from the pool for as long as somebody reads them: the look-ahead bounds both. Thread-bound.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "online/second_layer.h"

namespace hdrcam {

struct PendingFrame {
  ExposedFrame frame;
  float stated_blur = 0;               // share of its motion that blurs it by its facts
  StateMotion motion;                  // between the state at the frame before and this one
  std::optional<SceneEstimate> scene;  // none where the second layer rests
  // After this frame, where a later one was taken into the state before this one was emitted; else empty. The
  // state's pictures are borrowed.
  RadianceState state;
  DepthMap depth;
  bool advanced = false;  // the state has taken it in
  bool emitted = false;   // or left out
};

class PendingFrames {
 public:
  // pool: lends pictures; it outlives the frames.
  explicit PendingFrames(WorkerPool& pool) : pool_(pool) {}

  bool empty() const { return frames_.empty(); }
  std::size_t size() const { return frames_.size(); }
  // place: 0 is the oldest.
  PendingFrame& operator[](std::size_t place) { return *frames_[place]; }

  // Takes the newest frame, whose storage it exchanges.
  PendingFrame& add(ExposedFrame& frame);
  // Lets go the oldest ones that are emitted; the newest stays.
  void retire_emitted();
  void retire_all();

  // Between time stamps, which may be wrong. The time from the frame before to this one, over that of the
  // step before it (MotionContext::before_ratio): within 0.1..10, and 1 where an interval cannot be.
  float before_ratio(std::size_t place) const;
  // The same time as a part of that from the frame before to the one after this one, which is there
  // (MotionContext::after_ratio): within 0.1..0.9, and 0.5 where an interval cannot be.
  float after_ratio(std::size_t place) const;

  // The motion from the frame before to this one: earlier frames look along it to this one until nobody does
  // any more.
  void borrow_motion_from_previous(std::size_t place);
  void return_motion_from_previous(std::size_t place);
  // Copies the state after this frame, and its depth, before both go on to the next one.
  void keep_state(std::size_t place, const RadianceState& state);

 private:
  Instant time_before(std::size_t place, std::size_t n) const;
  void retire_oldest();

  WorkerPool& pool_;
  std::vector<std::unique_ptr<PendingFrame>> frames_;
  std::vector<std::unique_ptr<PendingFrame>> spare_;  // for reuse
  std::size_t retired_ = 0;                           // number of the frames before them
  std::array<Instant, 2> retired_times_{};            // of these the newest two, the newest first
};

}  // namespace hdrcam
