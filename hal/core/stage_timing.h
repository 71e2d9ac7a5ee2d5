// The timed stages of a frame, in the order of its way, and who is told how long each took. A watch is
// thread-bound.
#pragma once

#include <functional>

#include "hal/core/stopwatch.h"

namespace hdrcam {

enum class Stage {
  Unpack,
  Motion,
  Noise,
  State,
  Pose,
  Fit,
  LookAhead,
  Emission,
  FieldRender,
  Exposures,
  Sinks
};

// As statistics, reports and traces call it; of static storage.
constexpr const char* name(Stage stage) {
  switch (stage) {
    case Stage::Unpack:
      return "unpack";
    case Stage::Motion:
      return "motion";
    case Stage::Noise:
      return "noise";
    case Stage::State:
      return "state";
    case Stage::Pose:
      return "pose";
    case Stage::Fit:
      return "fit";
    case Stage::LookAhead:
      return "look-ahead";
    case Stage::Emission:
      return "emission";
    case Stage::FieldRender:
      return "field render";
    case Stage::Exposures:
      return "exposures";
    case Stage::Sinks:
      break;
  }
  return "sinks";
}

// Called on the thread that worked, once it has.
using StageTiming = std::function<void(Stage stage, double ms)>;

// Times the stages of one call, one after the other. An empty timing is not called, and no lap is taken. The
// timing outlives the watch.
class StageWatch {
 public:
  explicit StageWatch(const StageTiming& timing) : timing_(timing) {}
  // The stage that has ended: it took the time since the construction or the last lap.
  void lap(Stage stage) {
    if (timing_) timing_(stage, watch_.lap_ms());
  }

 private:
  const StageTiming& timing_;
  Stopwatch watch_;
};

}  // namespace hdrcam
