// Every knob of the method in one table: its name in `--set NAME=VALUE` and TOML, unit, range, its cost and
// its effect; knobs_of() has the values of each preset. `Knobs::budget` holds the knobs that may change from
// frame to frame and is passed with each call; all others are fixed at the start of a run. Plain values;
// reentrant.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/result.h"
#include "online/frame_budget.h"
#include "online/priors/depth/dynamic_depth.h"
#include "online/response/response_estimator.h"
#include "online/scene/hash_grid/fit/field_options.h"
#include "online/scene/scene_fields.h"
#include "online/state/state_filter.h"

namespace hdrcam {

// Points on the measured Pareto front of quality and time (docs/decisions).
enum class Preset { Realtime, Fast, Balanced, Best };
const char* name(Preset preset);

// The noise model of a run: measured from its frames, or as assumed at the start, for comparison.
enum class NoiseKind { Assumed, Learned };

// Motion blur that is modelled: none, what exposure times state, or that as far as frames show it
// (state/shown_blur.h).
enum class BlurKind { Off, Stated, Shown };

// Light from one frame to the next: as steady as exposures say, or followed where frames show that it is not
// (state/frame_light.h).
enum class LightKind { Steady, Followed };

struct Knobs {
  FrameBudget budget;
  int look_ahead = 1;                       // later frames that an emission waits for: 0..2, or kAsSizeAllows
  static constexpr int kAsSizeAllows = -1;  // look_ahead is two for small pictures, else one: look_ahead_of()
  int bootstrap_frames = 6;  // 2..64: frames from which the response is estimated before the first emission
  int view_steps = 30;       // 0..1000: fit steps per frame where the field itself is to be seen
  float code_noise = 1;      // codes rms (NoiseModel)
  NoiseKind noise = NoiseKind::Learned;
  BlurKind motion_blur = BlurKind::Shown;
  LightKind light = LightKind::Followed;
  ResponseModel response = ResponseModel::Curve;  // of frames whose response is unknown
  StateOptions state;
  PoseKind pose = PoseKind::Given;
  DepthOptions depth;
  DynamicDepthOptions dynamic_depth;
  FieldKind field = FieldKind::HashGrid;
  FieldStep field_step = FieldStep::Auto;
  FieldOptions hash_grid;
};
Knobs knobs_of(Preset preset);
// Frames that an emission waits for, of pictures of this size.
int look_ahead_of(const Knobs& knobs, int rows, int cols);

enum class KnobKind { Whole, Real, Choice };
enum class KnobChange { PerFrame, AtStart };

struct Knob {
  std::string name;       // "steps"
  const char* unit = "";  // "steps", "px"; "" for a share or a choice
  KnobKind kind = KnobKind::Real;
  KnobChange change = KnobChange::AtStart;
  double least = 0, most = 0;             // limits of a number
  int multiple = 1;                       // whole numbers are a multiple of this
  std::vector<std::string> choices = {};  // words of a choice
  const char* costs = "";                 // the cost of a larger value
  const char* gives = "";                 // the effect, and a reason to change it
  double (*get)(const Knobs&) = nullptr;  // the index of a choice
  void (*put)(Knobs&, double) = nullptr;  // unchecked: set_knob() checks
};

// In the order of the processing of a frame. Built once, at the first call.
std::span<const Knob> knob_table();

// The value as set_knob() reads it. Invalid for an unknown name, naming the nearest ones.
Result<std::string> knob_value(const Knobs& knobs, std::string_view name);
// Invalid for an unknown name, or a value that does not parse or is out of range; the message states the
// valid values.
Result<void> set_knob(Knobs& knobs, std::string_view name, std::string_view value);
// The valid values as text for help and messages: "a whole number, 0..1000 steps".
std::string accepted_values(const Knob& knob);

}  // namespace hdrcam
