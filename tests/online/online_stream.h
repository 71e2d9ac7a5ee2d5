// Capture's end and the online stage, as a run joins them, for tests that feed frames and read estimates.
#pragma once

#include <optional>

#include "capture/exposed_stream.h"
#include "online/online_stage.h"

namespace hdrcam::test {

inline Knobs state_alone() {
  Knobs knobs;
  knobs.field = FieldKind::None;
  return knobs;
}

class OnlineStream {
 public:
  OnlineStream(const CameraFacts& camera, const Knobs& options, WorkerPool& pool)
      : exposed_(camera, options.bootstrap_frames, StatedBlack::Kept),
        online_(options, camera, std::nullopt, pool) {}

  Result<void> take(const RawFrame& raw, const FrameBudget& budget, const OnlineStage::Emit& emit) {
    return exposed_.take(raw, to_online(budget, emit));
  }
  Result<void> finish(const FrameBudget& budget, const OnlineStage::Emit& emit) {
    TRY(exposed_.finish(to_online(budget, emit)));
    return online_.finish(emit);
  }
  OnlineStage& online() { return online_; }
  void freeze_exposures() { frozen_ = true; }  // as if every exposure were an instant

 private:
  ExposedStream::HandOn to_online(const FrameBudget& budget, const OnlineStage::Emit& emit) {
    return [&](ExposedFrame& frame) {
      if (frozen_) frame.blur_fraction = 0;
      return online_.ingest(frame, budget, emit);
    };
  }

  bool frozen_ = false;
  ExposedStream exposed_;
  OnlineStage online_;
};

}  // namespace hdrcam::test
