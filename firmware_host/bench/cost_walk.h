// What accuracy costs in time: a walk over the knobs of the method. Each point of the walk is one setting of
// the fit; it runs over clips with ground truth, is timed without its sinks, and scored. Thread-bound.
#pragma once

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "firmware_host/settings/settings.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

struct CostPoint {
  std::string name;   // "look-ahead 0"
  std::string group;  // the knob that is walked: "look-ahead", or "preset"
  Settings::Fit fit;
};

// The presets, and from `base` one knob after the other.
std::vector<CostPoint> cost_points(const Settings::Fit& base);

// One point on one clip.
struct PointCost {
  std::string point, group, clip;
  int frames = 0;                  // that left
  double mean_ms = 0, p95_ms = 0;  // per frame, all stages but the sinks
  double psnr_mu_db = 0, worst_psnr_mu_db = 0, flicker_stops = 0;
};

struct CostWalk {
  std::vector<CostPoint> points;
  std::vector<std::string> clips;  // folders with clip.json and gt/
  int frames = 0;                  // of each clip; 0: all
  int repeats = 1;                 // runs of each point and clip; the fastest counts
};

// For each point and clip; a clip's points run one after the other, so that a drift of the machine's speed
// spreads over the clips. `scratch`: a folder that does not exist yet; it holds HDR frames for a while, and
// is removed. costs: gets what was measured, also when the walk ends early. Errors: those of the clips
// (render/scores/scores.h) and of run(); Interrupted.
Result<void> walk(const CostWalk& plan, const Settings& settings, const std::string& scratch,
                  Storage& storage, const std::atomic<bool>& stop, std::vector<PointCost>& costs);

// A point's mean over the clips, in the order of the points.
std::vector<PointCost> means_of(std::span<const PointCost> costs);

}  // namespace hdrcam
