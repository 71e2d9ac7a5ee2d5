#include "firmware_host/bench/cost_walk.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <system_error>

#include "firmware_host/run/recording_source.h"
#include "firmware_host/run/run.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/terminal.h"
#include "hal/recording/image_sequence.h"
#include "render/scores/scores_json.h"

namespace hdrcam {
namespace {

namespace fs = std::filesystem;

// Removes the folder and what is in it.
struct Scratch {
  std::string folder;
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
};

// What all runs of a walk share.
class CostRuns {
 public:
  // All outlives it. scratch: the folder of the HDR frames that are scored.
  CostRuns(const CostWalk& plan, const Settings& settings, const std::string& scratch, Storage& storage,
           const std::atomic<bool>& stop)
      : plan_(plan), settings_(settings), scratch_(scratch), storage_(storage), stop_(stop) {}

  Result<PointCost> measure(const CostPoint& point, const std::string& clip) const {
    const Settings settings = settings_of(point);
    PointCost cost{.point = point.name, .group = point.group, .clip = folder_name(clip)};
    const Scratch removed{scratch_};
    TRY(storage_.make_directories(scratch_));
    cost.mean_ms = std::numeric_limits<double>::infinity();
    for (int i = 0; i < plan_.repeats; ++i) TRY(run_once(settings, clip, cost));
    const ClipScores scores = TRY(score_clip(storage_, clip, scratch_, {.stop = &stop_}));
    cost.psnr_mu_db = scores.mean.psnr_mu_db;
    cost.worst_psnr_mu_db = scores.worst.picture.psnr_mu_db;
    cost.flicker_stops = scores.flicker_stops.value_or(std::numeric_limits<double>::quiet_NaN());
    return cost;
  }

 private:
  Settings settings_of(const CostPoint& point) const {
    Settings settings = settings_;
    settings.fit = point.fit;
    settings.output = {};  // a layer or a white balance would be part of the time and of the error
    settings.output.paths = {{std::string(sink_name::kFrames), scratch_ + "/%06d.exr"}};
    settings.output.compression = FrameCompression::None;
    return settings;
  }

  // cost: keeps the times of the fastest run.
  Result<void> run_once(const Settings& settings, const std::string& clip, PointCost& cost) const {
    const auto source = RecordingSource::of(reader_of(TRY(ImageSequence::open(storage_, clip))),
                                            {.frames = plan_.frames}, stop_);
    RunRecord record;
    TRY(run({.settings = settings, .stop = &stop_, .progress = nullptr, .record = &record}, *source,
            storage_));
    const StageSummary method = method_summary(record);
    if (method.mean_ms < cost.mean_ms) cost.mean_ms = method.mean_ms, cost.p95_ms = method.p95_ms;
    cost.frames = method.frames;
    return {};
  }

  const CostWalk& plan_;
  const Settings& settings_;
  const std::string& scratch_;
  Storage& storage_;
  const std::atomic<bool>& stop_;
};

CostPoint with_knob(const Settings::Fit& base, const std::string& group, const char* knob,
                    const std::string& value) {
  CostPoint point{group + " " + value, group, base};
  point.fit.knobs[knob] = value;
  return point;
}

}  // namespace

std::vector<CostPoint> cost_points(const Settings::Fit& base) {
  std::vector<CostPoint> points;
  for (const Preset preset : {Preset::Realtime, Preset::Fast, Preset::Balanced, Preset::Best}) {
    points.push_back({name(preset), "preset", base});
    points.back().fit.preset = preset;
  }
  for (const char* frames : {"0", "1"}) points.push_back(with_knob(base, "look-ahead", "look_ahead", frames));
  for (const char* flow : {"fast", "medium"}) points.push_back(with_knob(base, "flow", "flow", flow));
  points.push_back(with_knob(base, "field", "field", "none"));
  for (const char* steps : {"0", "10", "30"}) points.push_back(with_knob(base, "steps", "steps", steps));
  for (const char* frames : {"3", "12"}) points.push_back(with_knob(base, "window", "window_frames", frames));
  for (const char* tiles : {"off", "on"}) points.push_back(with_knob(base, "shrinkage", "shrinkage", tiles));
  return points;
}

Result<void> walk(const CostWalk& plan, const Settings& settings, const std::string& scratch,
                  Storage& storage, const std::atomic<bool>& stop, std::vector<PointCost>& costs) {
  for (const std::string& clip : plan.clips) TRY(ImageSequence::open(storage, clip));  // before hours of work
  const CostRuns runs(plan, settings, scratch, storage, stop);
  for (const std::string& clip : plan.clips)
    for (const CostPoint& point : plan.points) {
      costs.push_back(TRY(runs.measure(point, clip)));
      const PointCost& cost = costs.back();
      remark("{}, {}: {:.1f} ms a frame, {:.2f} dB\n", cost.clip, cost.point, cost.mean_ms, cost.psnr_mu_db);
    }
  return {};
}

std::vector<PointCost> means_of(std::span<const PointCost> costs) {
  std::vector<PointCost> means;
  std::vector<int> clips;
  for (const PointCost& cost : costs) {
    auto mean = std::ranges::find(means, cost.point, &PointCost::point);
    if (mean == means.end()) {
      means.push_back({.point = cost.point, .group = cost.group, .clip = "mean"});
      clips.push_back(0);
      mean = means.end() - 1;
    }
    ++clips[static_cast<std::size_t>(mean - means.begin())];
    mean->frames += cost.frames;
    mean->mean_ms += cost.mean_ms, mean->p95_ms += cost.p95_ms;
    mean->psnr_mu_db += cost.psnr_mu_db, mean->worst_psnr_mu_db += cost.worst_psnr_mu_db;
    mean->flicker_stops += cost.flicker_stops;
  }
  for (std::size_t i = 0; i < means.size(); ++i) {
    PointCost& mean = means[i];
    for (double* sum :
         {&mean.mean_ms, &mean.p95_ms, &mean.psnr_mu_db, &mean.worst_psnr_mu_db, &mean.flicker_stops})
      *sum /= clips[i];
  }
  return means;
}

}  // namespace hdrcam
