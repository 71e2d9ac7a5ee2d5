// Every knob of the method in one table: its name as `--set NAME=VALUE` and TOML take it, unit, range, what
// each preset sets it to, what it costs and what it gives. What may change from one frame to the next is
// `Knobs::budget` and enters with each call; all else holds from the start of a run. Plain values; reentrant.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/result.h"
#include "online/frame_budget.h"
#include "online/priors/depth/multi_view_depth.h"
#include "online/scene/scene_fields.h"
#include "online/state/state_filter.h"

namespace hdrcam {

// Points on the measured front of quality against time (docs/decisions.md).
enum class Preset { Fast, Balanced, Best };
const char* name(Preset preset);

struct Knobs {
  FrameBudget budget;
  int look_ahead = 1;        // frames, 0..2: how many later frames an emission waits for
  int bootstrap_frames = 6;  // 2..64: frames from which the response is estimated before the first emission
  float code_noise = 1;      // codes rms (NoiseModel)
  StateOptions state;
  PoseKind pose = PoseKind::Given;
  DepthOptions depth;
  FieldKind field = FieldKind::HashGrid;
  FieldOptions hash_grid;
};
Knobs knobs_of(Preset preset);

enum class KnobKind { Whole, Real, Choice };
enum class KnobChange { PerFrame, AtStart };

struct Knob {
  std::string name;  // "steps"
  const char* unit;  // "steps", "px"; "" for a share or a choice
  KnobKind kind;
  KnobChange change;
  double least, most;                // of a number
  int multiple;                      // a whole number is a multiple of this
  std::vector<std::string> choices;  // of a choice
  const char* costs;                 // what more of it costs
  const char* gives;                 // what it gives, and why one would turn it
  double (*get)(const Knobs&);       // of a choice: its index
  void (*put)(Knobs&, double);       // unchecked: set_knob() checks
};

// In the order of a frame's way. Built once, at the first call.
std::span<const Knob> knob_table();

// The value as set_knob() reads it. Invalid for a name that no knob has, naming the nearest ones.
Result<std::string> knob_value(const Knobs& knobs, std::string_view name);
// Invalid for an unknown name, a value that does not parse or is out of range; the message says what would
// do.
Result<void> set_knob(Knobs& knobs, std::string_view name, std::string_view value);
// The same for "NAME=VALUE", as a command line has it.
Result<void> set_knob(Knobs& knobs, std::string_view assignment);
// "a whole number, 0..1000 steps": for help and messages.
std::string accepted_values(const Knob& knob);

}  // namespace hdrcam
