#include "firmware_host/run/pipeline.h"

#include "capture/companding.h"
#include "hal/core/stopwatch.h"

namespace hdrcam {
namespace {

std::optional<Response> known_response(const CameraFacts& camera) {
  if (camera.linear) return Response::gamma(kCompanding);
  if (camera.response.size() != 3) return std::nullopt;
  std::array<Response::Curve, 3> inverse{};
  for (std::size_t c = 0; c < 3; ++c) {
    if (camera.response[c].size() != Response::kCodes) return std::nullopt;
    for (std::size_t z = 0; z < Response::kCodes; ++z)  // before Response, whose least step is of exposure 1
      inverse[c][z] = static_cast<float>(camera.response[c][z] / camera.response[c].back());
  }
  return Response(inverse);
}

// The stages that cost the same on every rung of the ladder.
bool is_steady(Stage stage) {
  return stage == Stage::Unpack || stage == Stage::Noise || stage == Stage::State;
}

}  // namespace

Pipeline::Pipeline(const PipelineOptions& options, const CameraFacts& camera, WorkerPool& pool,
                   GpuDevice* gpu)
    : Pipeline(options, camera, known_response(camera), pool, gpu) {}

Pipeline::Pipeline(const PipelineOptions& options, const CameraFacts& camera,
                   const std::optional<Response>& response, WorkerPool& pool, GpuDevice* gpu)
    : camera_(camera),
      budget_(options.knobs.budget),
      exposed_(camera, options.knobs.bootstrap_frames, response ? StatedBlack::Removed : StatedBlack::Kept),
      online_(options.knobs, camera, response, pool, gpu),
      render_(options.render, pool, gpu) {
  const auto time = [this](Stage stage, double ms) {
    add_to(record_.stages_ms, {name(stage), ms});
    if (trace_ != nullptr) trace_->add_stage(name(stage), ms);
    if (is_steady(stage)) work_.steady_ms += ms;
  };
  exposed_.set_timing(time);
  online_.set_timing(time);
  render_.set_timing(time);
  online_.set_left_out([this] {
    ++work_.frames;
    if (left_out_) left_out_();
  });
}

Result<void> Pipeline::take(const RawFrame& raw, const FrameBudget& budget, const Deliver& deliver) {
  work_ = {};
  record_.stages_ms.clear();  // of a frame that was not emitted
  if (raw.codes.rows() != camera_.height || raw.codes.cols() != camera_.width)
    return Error{
        ErrorCode::SizeChanged,
        fmt::format("frame {} is {}x{}, the clip is {}x{}; split the clip where its size changes",
                    raw.facts.sequence, raw.codes.cols(), raw.codes.rows(), camera_.width, camera_.height)};
  if (is_kept_out(raw.facts)) {
    ++kept_out_;
    return {};
  }
  if (!first_time_) first_time_ = raw.facts.timestamp;
  Stopwatch watch;
  const auto hand_on = [&](ExposedFrame& frame) { return ingest(frame, budget, deliver); };
  TRY(exposed_.take(raw, std::ref(hand_on)));  // a reference, because a copy would allocate
  work_.total_ms = watch.lap_ms();
  return {};
}

Result<void> Pipeline::ingest(ExposedFrame& frame, const FrameBudget& budget, const Deliver& deliver) {
  return online_.ingest(frame, budget,
                        [&](const FrameEstimate& estimate) { return render(estimate, deliver); });
}

Result<void> Pipeline::finish(const Deliver& deliver) {
  work_ = {};
  TRY(exposed_.finish([&](ExposedFrame& frame) { return ingest(frame, budget_, deliver); }));
  return online_.finish([&](const FrameEstimate& estimate) { return render(estimate, deliver); });
}

Result<void> Pipeline::render(const FrameEstimate& estimate, const Deliver& deliver) {
  ++work_.frames;
  render_.render(estimate, frame_);
  if (estimate.fit != nullptr) {
    record_.fit_steps = estimate.fit->steps;
    for (const FitReport::Loss& loss : estimate.fit->losses)
      record_.losses.push_back({loss.name, loss.value});
    if (estimate.fit->rolled_back > 0)
      record_.note =
          fmt::format("{} of {} steps rolled back", estimate.fit->rolled_back, estimate.fit->steps);
  }
  describe_frame(frame_, to_seconds(frame_.facts.timestamp - *first_time_), record_);
  record_.total_ms = 0;
  for (const NamedValue& stage : record_.stages_ms) record_.total_ms += stage.value;
  auto delivered = deliver(frame_, estimate, record_);
  record_.stages_ms.clear(), record_.losses.clear(), record_.note.clear();
  record_.fit_steps = 0;
  return delivered;
}

}  // namespace hdrcam
