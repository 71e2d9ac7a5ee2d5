#include "firmware_host/run/fit_run.h"

#include <algorithm>

namespace hdrcam {

std::string flags_of(const Settings::Fit& fit) {
  const Settings::Fit usual;
  std::string text = fmt::format(" --preset {} --emit {}", fit.preset, fit.emit);
  if (fit.lookahead != usual.lookahead) text += fmt::format(" --lookahead {}", fit.lookahead);
  if (fit.code_noise != usual.code_noise) text += fmt::format(" --code-noise {:g}", fit.code_noise);
  return text + fmt::format(" --seed {}", fit.seed);
}

Result<std::unique_ptr<FitRun>> FitRun::open(const Settings& settings, const CameraFacts& camera,
                                             std::string title, std::string command, Storage& storage,
                                             std::function<void(FrameRecord&)> emitted, FrameSource source) {
  const PipelineOptions options = TRY(options_of(settings.fit));
  Outputs outputs = TRY(Outputs::open(settings.output, camera, storage));
  std::unique_ptr<FitRun> run(new FitRun(options, camera, thread_count(settings.fit), source,
                                         std::move(outputs), std::move(emitted)));
  RunRecord& record = run->record_;
  record.title = std::move(title);
  record.command = std::move(command);
  record.preset = settings.fit.preset;
  record.seed = static_cast<std::uint64_t>(settings.fit.seed);
  record.threads = run->pool_.threads();
  record.camera = camera.name;
  record.width = camera.width, record.height = camera.height;
  record.framerate_hz = camera.framerate_hz;
  return run;
}

FitRun::FitRun(const PipelineOptions& options, const CameraFacts& camera, int threads, FrameSource source,
               Outputs outputs, std::function<void(FrameRecord&)> emitted)
    : pool_(threads, source == FrameSource::Camera ? ThreadPriority::Background : ThreadPriority::Usual),
      pipeline_(options, camera, pool_),
      outputs_(std::move(outputs)),
      frames_kept_(source == FrameSource::Camera ? kFramesKept : std::numeric_limits<std::size_t>::max()),
      emitted_(std::move(emitted)),
      deliver_([this](const HdrFrame& frame, const ExposedFrame& input, const FrameRecord& facts) {
        return deliver(frame, input, facts);
      }) {
  if (source == FrameSource::Clip) return;
  record_.frames.resize(kFramesKept);  // so that the memory is really there, not only reserved
  record_.frames.clear();
}

Result<void> FitRun::take(const RawFrame& frame) {
  ++record_.captured;
  return pipeline_.take(frame, deliver_);
}

Result<void> FitRun::deliver(const HdrFrame& frame, const ExposedFrame& input, const FrameRecord& facts) {
  TRY(outputs_.emit(frame, input));
  ++record_.emitted;
  auto& frames = record_.frames;
  if (frames.size() < frames_kept_) frames.emplace_back();
  FrameRecord& kept = frames[static_cast<std::size_t>(record_.emitted - 1) % frames_kept_];
  kept = facts;
  if (emitted_) emitted_(kept);
  return {};
}

Result<void> FitRun::finish() {
  Result<void> drained = pipeline_.finish(deliver_);
  TRY(outputs_.finish());
  const OnlineStage& online = pipeline_.online();
  const auto oldest = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(record_.emitted) % frames_kept_);
  if (record_.frames.size() == frames_kept_)
    std::rotate(record_.frames.begin(), record_.frames.begin() + oldest, record_.frames.end());
  record_.dropped = record_.captured - record_.emitted;
  record_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  record_.peak_memory_mib = peak_memory_mib();
  record_.response = ResponseCurves{online.response().inverse(0), online.response().inverse(1),
                                    online.response().inverse(2)};
  record_.response_prior = prior_mean_response().inverse(1);
  const NoiseModel& noise = online.noise();
  record_.notes.push_back(fmt::format("noise: full well {:.0f} electrons, read noise {:.1f} electrons",
                                      noise.full_well, noise.read_noise));
  const BlackLevel& black = online.black_level();
  record_.notes.push_back(
      fmt::format("black level: {:.1f}, {:.1f}, {:.1f} codes of 255", black[0], black[1], black[2]));
  if (pipeline_.kept_out() > 0)
    record_.notes.push_back(fmt::format(
        "{} frame(s) kept out of the fit: exposure not proved, or pixels damaged", pipeline_.kept_out()));
  if (static_cast<int>(record_.frames.size()) < record_.emitted)
    record_.notes.push_back(fmt::format("times are those of the last {} frames", record_.frames.size()));
  return drained;
}

Result<void> FitRun::conclude() { return outputs_.conclude(record_); }

}  // namespace hdrcam
