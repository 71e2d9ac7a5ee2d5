#include "tests/quality/closed_loop.h"

#include <algorithm>
#include <cmath>

#include "capture/capture_stage.h"
#include "firmware_host/live/live_report.h"
#include "firmware_host/run/run.h"
#include "hal/sim/sim_bench.h"
#include "hal/sim/simulated_camera.h"
#include "render/scores/order_statistics.h"
#include "render/scores/picture_scores.h"
#include "tests/contracts/expect.h"

namespace hdrcam::test {
namespace {

// Beyond rounding to lines and gain codes, of ln E.
constexpr double kWrongLabel = 0.1;

// The simulated camera in virtual time as the source of a run: the next frame waits until the last one was
// fitted, and a cycle that the fit asks for is that of the next request.
class LoopedCamera : public FrameSource {
 public:
  LoopedCamera(const Simulation& simulation, const LoopRun& wanted)
      : camera_(simulation, SimTime(clock_), 1),
        bench_(camera_),
        frames_(wanted.frames),
        adapt_(wanted.schedule.adapt) {
    CaptureOptions options;
    options.adapt = adapt_;
    options.mode = {PixelFormat::Rgb24, simulation.width, simulation.height, simulation.frame_duration()};
    stage_ = value_of(CaptureStage::open(
        camera_, nullptr, value_of(parse_exposures(wanted.schedule.shutter, wanted.schedule.gain)),
        wanted.schedule.mains, options));
    facts_ = stage_->facts();
  }

  const CameraFacts& camera() const override { return facts_; }
  RunPace pace() const override { return RunPace::Clip; }
  Result<void> start() override { return stage_->start(); }
  Result<const RawFrame*> next() override {
    if (taken_ == frames_) return nullptr;
    ++taken_;
    TRY(stage_->next(frame_));
    if (frame_.proof.trusted()) {
      const auto truth = bench_.true_exposure(frame_.raw.facts.sequence);
      const Exposure actual{truth->exposure, truth->analogue_gain};
      wrong_ += std::abs(frame_.proof.label.log_value() - log_product(actual)) > kWrongLabel;
    }
    return &frame_.raw;
  }
  void learn_response(const Response::Curve& inverse, const BlackLevel& black_level) override {
    stage_->learn_response(inverse, black_level);
  }
  std::optional<ExposureLimits> exposure_limits() const override {
    return adapt_ == Adapt::Motion ? stage_->exposure_limits() : std::nullopt;
  }
  Result<void> follow(const std::vector<Exposure>& cycle) override {
    require_done(stage_->change_cycle(cycle));
    return {};
  }
  Result<void> finish(RunRecord& record) override {
    LiveCounters counters;
    counters.camera = stage_->counters();
    record.counters = named(counters);
    return stage_->stop();
  }

  const SimulatedCamera& device() const { return camera_; }
  const CaptureStage& stage() const { return *stage_; }
  int wrong() const { return wrong_; }

 private:
  VirtualClock clock_;
  SimulatedCamera camera_;
  SimBench bench_;
  std::unique_ptr<CaptureStage> stage_;
  CameraFacts facts_;
  CapturedFrame frame_;
  const int frames_;
  const Adapt adapt_;
  int taken_ = 0, wrong_ = 0;
};

struct KeptFrame {
  FrameFacts facts;
  Image<float> radiance;
};
std::vector<KeptFrame>* kept_frames = nullptr;  // of the loop that runs

class KeepingSink : public FrameSink {
 public:
  Result<void> emit(const EmittedFrame& frame) override {
    kept_frames->push_back({frame.hdr.facts, frame.hdr.radiance.clone()});
    return {};
  }
};
constexpr SinkKind kKinds[] = {{"kept", "--kept", "keeps the frames", SinkPace::Light, SinkTarget::Files,
                                [](const SinkRequest&) -> Result<std::unique_ptr<FrameSink>> {
                                  return std::unique_ptr<FrameSink>(std::make_unique<KeepingSink>());
                                }}};

// The truth at the middle of picture and exposure of each frame.
std::vector<Image<float>> truths_of(const std::vector<KeptFrame>& frames, const SimulatedSensor& sensor,
                                    WorkerPool& pool) {
  const Simulation& s = sensor.simulation();
  const double readout_s = to_seconds(s.readout());
  TruthRenderer renderer(*sensor.scene(), sensor.lens(), s.height, s.width, pool, sensor.vignetting());
  std::vector<Image<float>> truths;
  SceneTruth truth;
  for (const KeptFrame& frame : frames) {
    const double begin_s = static_cast<double>(frame.facts.sequence) * to_seconds(s.frame_duration());
    const double middle_s = begin_s + (frame.facts.exposure_s + readout_s) / 2;
    renderer.render(middle_s, middle_s + to_seconds(s.frame_duration()), truth);
    truths.push_back(truth.radiance.clone());
  }
  return truths;
}

// As render/scores/scores.h normalises a clip.
Normalisation normalisation_of(const std::vector<KeptFrame>& frames, const std::vector<Image<float>>& truths,
                               double saturation) {
  constexpr float kFrom = 0.004f, kTo = 0.6f;  // of white: well exposed
  std::vector<float> brightest;
  for (const Image<float>& g : truths)
    for (std::size_t i = 0; i < g.plane_size(); i += 7)
      brightest.push_back(std::max({g.plane(0)[i], g.plane(1)[i], g.plane(2)[i]}));
  Normalisation shared;
  shared.white = std::min(percentile(brightest, 99.9), saturation);
  const auto white = static_cast<float>(shared.white);
  for (int c = 0; c < 3; ++c) {
    std::vector<float> log_ratios;
    for (std::size_t k = 0; k < frames.size(); ++k)
      for (std::size_t i = 0; i < truths[k].plane_size(); i += 11)
        if (const float t = truths[k].plane(c)[i], v = frames[k].radiance.plane(c)[i];
            t > kFrom * white && t < kTo * white && v > 0)
          log_ratios.push_back(std::log(t / v));
    shared.gain[static_cast<std::size_t>(c)] = std::exp(numpy_median(log_ratios));
  }
  return shared;
}

}  // namespace

LoopOutcome closed_loop(const LoopRun& wanted) {
  const Simulation simulation = value_of(simulation_of(wanted.scene));
  LoopedCamera source(simulation, wanted);
  std::vector<KeptFrame> frames;
  kept_frames = &frames;
  LoopOutcome outcome;
  RunPlan plan{.title = "closed loop", .sinks = kKinds, .progress = nullptr, .record = &outcome.record};
  plan.settings.schedule = wanted.schedule;
  plan.settings.fit.emit = EmitLayer::State;
  plan.settings.fit.threads = 1;
  plan.settings.output.paths["kept"] = "in memory";
  double first_shortest = 1e9;
  for (const Exposure& exposure : source.stage().schedule().cycle())
    first_shortest = std::min(first_shortest, exposure.product());
  require_done(run(plan, source, posix_storage()));

  std::erase_if(frames, [&](const KeptFrame& frame) {
    return frame.facts.sequence < static_cast<std::uint64_t>(wanted.first_scored);
  });
  REQUIRE_FALSE(frames.empty());
  WorkerPool pool(1);
  const std::vector<Image<float>> truths = truths_of(frames, *source.device().sensor(), pool);
  const Normalisation shared =
      normalisation_of(frames, truths, 1 / (first_shortest * simulation.sensitivity_per_s));
  outcome.worst_db = 1e9;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double db = psnr_mu_db(truths[k], frames[k].radiance, shared);
    outcome.mean_db += db / static_cast<double>(frames.size());
    outcome.worst_db = std::min(outcome.worst_db, db);
  }
  outcome.wrong_labels = source.wrong();
  outcome.changes = static_cast<int>(source.stage().counters().cycle_changes);
  for (const Exposure& exposure : source.stage().schedule().cycle()) outcome.last_cycle.push_back(exposure);
  return outcome;
}

}  // namespace hdrcam::test
