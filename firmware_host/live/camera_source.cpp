#include "firmware_host/live/camera_source.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <span>

#include "firmware_host/cut_recording.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/live/live_report.h"
#include "firmware_host/run/memory_need.h"
#include "hal/core/counted.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {
namespace {

// Where a camera's pictures are others than those asked for: a driver takes the nearest that it has.
std::vector<std::string> differences(const Settings::Camera& asked, const CameraFacts& has,
                                     const std::string& sizes) {
  constexpr double kSameRate = 0.01;  // 29.97 for 30
  std::vector<std::string> notes;
  if ((asked.width > 0 && asked.width != has.width) || (asked.height > 0 && asked.height != has.height))
    notes.push_back(fmt::format("'{}' gives pictures of {}x{}, the nearest to --width and --height{}",
                                has.name, has.width, has.height,
                                sizes.empty() ? "" : "; its sizes in this format: " + sizes));
  if (asked.framerate_hz > 0 && std::abs(has.framerate_hz / asked.framerate_hz - 1) > kSameRate)
    notes.push_back(fmt::format("'{}' gives {}, not {:g}", has.name,
                                counted_per_second(has.framerate_hz, "frame"), asked.framerate_hz));
  return notes;
}

// Errors: Unsupported where the stream and the work on it need more memory than the settings allow.
Result<void> admit_stream(const Settings& settings, const StreamMode& mode, LiveWork work) {
  const int width = mode.width, height = mode.height;
  std::uint64_t bytes = capture_bytes(width, height, codes_of(mode.format).layout, settings,
                                      LiveOptions::kFewestFrames, LiveOptions::kMostFrames);
  if (work == LiveWork::Fit) bytes += fit_bytes(width, height, settings);
  if (is_simulated(settings.camera.id)) bytes += simulator_bytes(width, height);
  const char* const fit = work == LiveWork::Fit ? " with its fit" : "";
  return admit_parts(settings, fmt::format("a stream of {}x{}{}", width, height, fit), bytes);
}

// What a cycle that adapts follows, as a sentence names it.
const char* followed_by(Adapt adapt) { return adapt == Adapt::Light ? "light" : "motion"; }

// Errors: Invalid where a run without a fit would ask it for exposures.
Result<void> check_adapt(Adapt adapt, LiveWork work) {
  if (adapt != Adapt::Motion || work != LiveWork::RecordOnly) return {};
  return Error{ErrorCode::Invalid,
               "--adapt motion asks the fit, and this run only records; use --adapt light or 'hdrcam live'"};
}

// Errors: Invalid where the light would move no exposure.
Result<void> check_ends(Adapt adapt, std::span<const Exposure> cycle) {
  if (adapt != Adapt::Light || cycle.size() > 1) return {};
  return Error{
      ErrorCode::Invalid,
      "--adapt light moves the shortest and the longest exposure of a cycle, and this one has a single "
      "exposure; give a cycle such as --shutter 1ms,4ms,16ms, or leave out --adapt"};
}

}  // namespace

Result<std::unique_ptr<CameraSource>> CameraSource::open(const Settings& settings, LiveOptions limits,
                                                         Storage& storage, const std::atomic<bool>& stop) {
  TRY(check_adapt(settings.schedule.adapt, limits.work));
  std::unique_ptr<CameraSource> source(new CameraSource(settings, stop));
  if (const std::string& takes = settings.output.http_takes; !takes.empty())
    source->takes_.emplace(storage, TRY(FramePattern::parse("--http-record", takes, ".mkv")),
                           settings.record.codec);
  source->replayed_ = is_replayed(settings.camera.id);
  source->work_ = limits.work;
  source->lines_ = TRY(CameraLines::prepare(settings));  // before the camera's threads
  source->camera_ = TRY(open_camera(settings.camera.id, storage, source->lines_->wiring()));
  source->exposure_fixed_ = !source->camera_->capabilities().sets_exposure;
  CaptureSetup setup = TRY(capture_setup(settings, source->camera_->capabilities()));
  if (!source->exposure_fixed_) TRY(check_ends(settings.schedule.adapt, setup.cycle));
  TRY(source->lines_->open(setup.options.mode.frame_duration));
  setup.options.trigger = source->lines_->trigger();
  TRY(admit_stream(settings, setup.options.mode, limits.work));
  source->capture_ = TRY(CaptureStage::open(*source->camera_, source->lines_->strobe(), setup.cycle,
                                            setup.mains, setup.options));
  source->facts_ = source->capture_->facts();
  StreamMode taken = setup.options.mode;
  taken.width = source->facts_.width, taken.height = source->facts_.height;
  TRY(admit_stream(settings, taken, limits.work));  // a driver may have none as small as asked for
  if (!source->replayed_)
    source->differences_ =
        differences(settings.camera, source->facts_, sizes_of(source->camera_->capabilities(), taken));
  std::unique_ptr<RecordingWriter> recording;
  if (!settings.record.file.empty())
    recording = TRY(create_recording(storage, settings.record.file, source->facts_, Creation::Replace,
                                     settings.record.codec));
  limits.memory_bytes = static_cast<std::size_t>(settings.record.memory_mib) << 20;
  source->session_ = std::make_unique<LiveSession>(*source->capture_, std::move(recording), limits);
  return source;
}

std::vector<std::string> CameraSource::warnings() const {
  std::vector<std::string> all = differences_;
  std::ranges::copy(capture_->warnings(), std::back_inserter(all));
  if (const std::string note = lines_->note(); !note.empty()) all.push_back(note);
  if (work_ == LiveWork::Fit && !exposure_fixed_ && capture_->schedule().slots() == 1)
    all.emplace_back("one exposure gives no HDR; give a cycle such as --shutter 1ms,4ms,16ms");
  return all;
}

Result<void> CameraSource::start() {
  TRY(session_->start(stop_));
  watch_.emplace(
      Supervisor::of_environment(), [this] { return session_->counters(); },
      [this](const LiveCounters& counters) {
        return live_line(to_seconds(posix_clock().now() - begin_), counters, work_);
      });
  return {};
}

Result<const RawFrame*> CameraSource::next() {
  frame_ = {};  // returned first, so that capture can reuse it
  frame_ = session_->next({});
  return frame_ ? &frame_->captured.raw : nullptr;
}

void CameraSource::emitted(FrameRecord& record) {
  record.latency_ms = to_seconds(session_->emitted(record.sequence)) * 1e3;
}

void CameraSource::learn_response(const Response::Curve& inverse, const BlackLevel& black_level) {
  session_->learn_response(inverse, black_level);
}

std::optional<ExposureLimits> CameraSource::exposure_limits() const {
  return adapt_ == Adapt::Motion ? capture_->exposure_limits() : std::nullopt;
}

Result<void> CameraSource::finish(RunRecord& record) {
  frame_ = {};
  if (watch_) watch_->stopping();
  const Result<LiveEnd> end = session_->finish();
  if (end) end_ = end.value();
  const LiveCounters counters = session_->counters();
  record.counters = named(counters);
  record.captured = static_cast<int>(counters.captured());
  record.emitted = static_cast<int>(counters.emitted);
  record.dropped = static_cast<int>(counters.dropped());
  record.notes.push_back(proof_of(counters.camera));
  std::ranges::move(accounts(), std::back_inserter(record.notes));
  std::ranges::move(camera_->warnings(), std::back_inserter(record.notes));
  if (end || (replayed_ && end.error().code == ErrorCode::Unplugged)) return {};
  if (const auto frames = session_->recording_cut_after())
    return cut_recording(end.error(), own_recording_, *frames);
  if (takes_ && session_->last_take_failed()) return takes_->cut(end.error(), counters.in_takes);
  return end.error();
}

std::vector<std::string> CameraSource::accounts() const {
  const CaptureCounters camera = session_->counters().camera;
  std::vector<std::string> all;
  for (const std::string& account : {capture_->exposures_account(), adaptation_account(),
                                     lines_->sentence(camera), lines_->strobe_sentence(camera)})
    if (!account.empty()) all.push_back(account);
  return all;
}

std::string CameraSource::adaptation_account() const {
  if (adapt_ == Adapt::Off) return "";
  const char* const followed = followed_by(adapt_);
  const std::uint64_t changes = session_->counters().camera.cycle_changes;
  if (changes == 0) return fmt::format("the {} did not change the cycle", followed);
  return fmt::format("the {} changed the cycle {}; last to {}", followed, counted(changes, "time"),
                     describe(capture_->schedule().cycle()));
}

std::string CameraSource::takes_account() const {
  return takes_ ? takes_->account(session_->counters().in_takes) : "";
}

std::vector<NamedValue> CameraSource::counters() const { return named(session_->counters()); }

Result<std::string> CameraSource::start_recording() {
  if (!takes_)
    return Error{ErrorCode::Unsupported,
                 "this run has no place for recordings; start it with --http-record takes/%03d.mkv"};
  TRY(session_->may_record());
  const std::uint64_t before = session_->counters().in_takes;
  Takes::Created take = TRY(takes_->create(facts_));
  Result<void> started;
  const std::exception_ptr thrown =
      thrown_by([&] { started = session_->start_recording(std::move(take.writer)); });
  if (!started || thrown != nullptr) takes_->discard(take.path);  // the run ended meanwhile, or the memory
  if (thrown != nullptr) std::rethrow_exception(thrown);
  TRY(started);
  takes_->started(take.path, before);
  recording_ = take.path;
  return recording_;
}

Result<void> CameraSource::stop_recording() {
  TRY(session_->stop_recording());
  recording_.clear();
  return {};
}

Result<void> CameraSource::change_cycle(const std::string& shutter, const std::string& gain) {
  if (exposure_fixed_) return Error{ErrorCode::Unsupported, "the exposures of this camera cannot be set"};
  if (adapt_ != Adapt::Off)
    return Error{ErrorCode::Unsupported,
                 fmt::format("the cycle follows the {} (--adapt)", followed_by(adapt_))};
  const std::string& kept = gain.empty() ? gain_ : gain;
  const double usual = usual_gain(camera_->capabilities());
  Result<std::vector<Exposure>> cycle = parse_exposures(shutter, kept, usual);
  // gains that nobody gave with it are not to blame: the session refuses another number of times in its words
  if (!cycle && gain.empty()) cycle = parse_exposures(shutter, "", usual);
  if (!cycle) return cycle.error();
  TRY(session_->change_cycle(cycle.value()));
  gain_ = kept;
  return {};
}

std::string CameraSource::status(const ProgressState&) const {
  return live_line(to_seconds(posix_clock().now() - begin_), session_->counters(), work_);
}

}  // namespace hdrcam
