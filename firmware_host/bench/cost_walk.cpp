#include "firmware_host/bench/cost_walk.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>

#include "firmware_host/run/recording_source.h"
#include "firmware_host/run/run.h"
#include "firmware_host/terminal.h"
#include "hal/recording/image_sequence.h"
#include "render/scores/scores.h"

namespace hdrcam {
namespace {

namespace fs = std::filesystem;

// A source that keeps the record of the run.
class WatchedSource : public FrameSource {
 public:
  explicit WatchedSource(std::unique_ptr<RecordingSource> source) : source_(std::move(source)) {}

  const CameraFacts& camera() const override { return source_->camera(); }
  RunPace pace() const override { return source_->pace(); }
  std::optional<int> frame_count() const override { return source_->frame_count(); }
  Result<const RawFrame*> next() override { return source_->next(); }
  Result<void> finish(RunRecord& record) override {
    Result<void> ended = source_->finish(record);
    record_ = record;
    return ended;
  }
  const RunRecord& record() const { return record_; }

 private:
  const std::unique_ptr<RecordingSource> source_;
  RunRecord record_;
};

// Removes the folder and what is in it.
struct Scratch {
  std::string folder;
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
};

double without_sinks(const FrameRecord& frame) {
  double ms = frame.total_ms;
  for (const NamedValue& stage : frame.stages_ms)
    if (stage.name == "sinks") ms -= stage.value;
  return ms;
}

struct Times {
  double mean_ms = std::numeric_limits<double>::infinity(), p95_ms = 0;
};
Times times_of(const RunRecord& record) {
  std::vector<double> ms;
  for (const FrameRecord& frame : record.frames) ms.push_back(without_sinks(frame));
  if (ms.empty()) return {0, 0};
  double sum = 0;
  for (const double v : ms) sum += v;
  const auto late = ms.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(ms.size() - 1));
  std::nth_element(ms.begin(), late, ms.end());
  return {sum / static_cast<double>(ms.size()), *late};
}

std::string clip_name(const std::string& folder) {
  const fs::path path = fs::path(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

Result<PointCost> measure(const CostPoint& point, const std::string& clip, const CostWalk& plan,
                          Settings settings, const std::string& scratch, Storage& storage,
                          const std::atomic<bool>& stop) {
  settings.fit = point.fit;
  settings.output.paths = {{"frames", scratch + "/%06d.exr"}};
  settings.output.compression = ExrCompression::None;
  PointCost cost{.point = point.name, .group = point.group, .clip = clip_name(clip)};
  const Scratch removed{scratch};
  TRY(storage.make_directories(scratch));
  Times best;
  for (int i = 0; i < plan.repeats; ++i) {
    WatchedSource source(RecordingSource::of(reader_of(TRY(ImageSequence::open(storage, clip))),
                                             {.frames = plan.frames}, stop));
    cost.width = source.camera().width, cost.height = source.camera().height;
    TRY(run({.settings = settings, .stop = &stop, .progress = nullptr}, source, storage));
    const Times times = times_of(source.record());
    if (times.mean_ms < best.mean_ms) best = times;
    cost.frames = static_cast<int>(source.record().frames.size());
  }
  cost.mean_ms = best.mean_ms, cost.p95_ms = best.p95_ms;
  const ClipScores scores = TRY(score_clip(storage, clip, scratch, {.stop = &stop}));
  cost.psnr_mu_db = scores.mean.psnr_mu_db;
  cost.worst_psnr_mu_db = scores.worst.picture.psnr_mu_db;
  cost.flicker_stops = scores.flicker_stops.value_or(std::numeric_limits<double>::quiet_NaN());
  return cost;
}

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
  for (const int frames : {0, 2}) {
    points.push_back({fmt::format("look-ahead {}", frames), "look-ahead", base});
    points.back().fit.lookahead = frames;
  }
  for (const char* flow : {"fast", "medium"}) points.push_back(with_knob(base, "flow", "flow", flow));
  points.push_back(with_knob(base, "field", "field", "none"));
  for (const char* steps : {"0", "10", "30"}) points.push_back(with_knob(base, "steps", "steps", steps));
  for (const char* frames : {"3", "12"}) points.push_back(with_knob(base, "window", "window_frames", frames));
  points.push_back(with_knob(base, "shrinkage", "shrinkage", "off"));
  return points;
}

Result<std::vector<PointCost>> walk(const CostWalk& plan, const Settings& settings,
                                    const std::string& scratch, Storage& storage,
                                    const std::atomic<bool>& stop) {
  std::vector<PointCost> costs;
  for (const std::string& clip : plan.clips)
    for (const CostPoint& point : plan.points) {
      costs.push_back(TRY(measure(point, clip, plan, settings, scratch, storage, stop)));
      const PointCost& cost = costs.back();
      remark("{}, {}: {:.1f} ms a frame, {:.2f} dB\n", cost.clip, cost.point, cost.mean_ms, cost.psnr_mu_db);
    }
  return costs;
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
