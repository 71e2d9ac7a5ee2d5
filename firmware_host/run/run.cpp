#include "firmware_host/run/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <future>
#include <limits>
#include <mutex>
#include <utility>

#include "firmware_host/film/virtual_camera.h"
#include "firmware_host/run/backend.h"
#include "firmware_host/run/deadline.h"
#include "firmware_host/run/novel_views.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/run/pipeline.h"
#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/terminal.h"
#include "hal/core/cpu.h"
#include "hal/core/stopwatch.h"
#include "hal/core/thread_name.h"
#include "online/exposure/cycle_choice.h"
#include "render/scores/scores.h"
#include "render/white_balance.h"

namespace hdrcam {
namespace {

// The progress of the run: written by the working thread, read by the one that shows it.
class SharedProgress {
 public:
  explicit SharedProgress(std::optional<int> total) { state_.total = total; }
  void frame_done(double ms, std::optional<double> loss) {
    const std::lock_guard lock(mutex_);
    state_.frame_done(ms, loss);
  }
  ProgressState now() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }

 private:
  mutable std::mutex mutex_;
  ProgressState state_;
};

RunRecord opened_record(const RunPlan& plan, const CameraFacts& camera, RunPace pace, int threads) {
  RunRecord record;
  record.title = plan.title;
  record.command = plan.command;
  record.preset = name(plan.settings.fit.preset);
  record.seed = static_cast<std::uint64_t>(plan.settings.fit.seed);
  record.threads = threads;
  record.camera = camera.name;
  record.width = camera.width, record.height = camera.height;
  record.framerate_hz = camera.framerate_hz;
  if (pace == RunPace::Camera) {
    record.frames.resize(kFramesKept);  // so that the memory is really there, not only reserved
    record.frames.clear();
  }
  return record;
}

// The record of a clip holds every frame. A camera may run for weeks, so only the latest frames are kept.
std::size_t frames_kept(RunPace pace) {
  return pace == RunPace::Camera ? kFramesKept : std::numeric_limits<std::size_t>::max();
}

FrameRecord& keep(const FrameRecord& frame, RunPace pace, RunRecord& record) {
  const std::size_t most = frames_kept(pace);
  if (record.frames.size() < most) record.frames.emplace_back();
  FrameRecord& kept = record.frames[static_cast<std::size_t>(record.emitted) % most];
  ++record.emitted;
  kept = frame;
  return kept;
}

// The governor of a run that has a deadline. A film is made without one: all frames of its window count.
std::optional<Governor> governor_of(const RunPlan& plan, const PipelineOptions& options, FieldUse use,
                                    const CameraFacts& camera, RunPace pace, PreviewUse previews) {
  const std::optional<Duration> deadline = deadline_of(plan.settings.fit, camera, pace);
  if (!deadline || plan.film != nullptr) return std::nullopt;
  FrameBudget asked = options.knobs.budget;
  asked.later_frames = look_ahead_of(options.knobs, camera.height, camera.width);
  return Governor(budget_ladder(asked, field_use(plan.settings, options, use), previews), *deadline);
}

void add_deadline(const Governor& governor, RunRecord& record) {
  record.late = governor.late();
  for (std::size_t r = 0; r < governor.ladder().size(); ++r)
    record.rungs.push_back({governor.ladder()[r].name, governor.frames_at()[r]});
}

// The camera parameters that the method estimated.
void add_findings(const Pipeline& pipeline, RunRecord& record) {
  const OnlineStage& online = pipeline.online();
  const SensorModel& sensor = online.sensor();
  record.response = ResponseCurves{sensor.response().inverse(0), sensor.response().inverse(1),
                                   sensor.response().inverse(2)};
  record.response_prior = prior_mean_response().inverse(1);
  if (!sensor.response_measured())
    record.notes.emplace_back("response: no frames tell it; the mean of real cameras stands in");
  for (const int frame : sensor.relearned())
    record.notes.push_back(
        fmt::format("response: learned anew from frame {} on; the frames before showed little of it", frame));
  const NoiseModel& noise = sensor.noise();
  record.notes.push_back(fmt::format("noise: full well {:.0f} electrons, read noise {:.1f} electrons",
                                     noise.full_well, noise.read_noise));
  if (const float share = sensor.texture_error(); share > 0)
    record.notes.push_back(
        fmt::format("the camera processes textures: a sample's variance has {:.0f} % of the local contrast",
                    100 * share));
  if (!sensor.blur_shown())
    record.notes.emplace_back(
        "motion blur: frames do not show what their exposure times state, so none is modelled (--set "
        "motion_blur=stated if they do)");
  const BlackLevel& black = sensor.black_level();
  record.notes.push_back(
      fmt::format("black level: {:.1f}, {:.1f}, {:.1f} codes of 255", black[0], black[1], black[2]));
  if (const std::string trouble = online.trouble(); !trouble.empty())
    record.notes.push_back("the processor went on with the state: " + trouble);
  if (const std::string trouble = online.field_trouble(); !trouble.empty())
    record.notes.push_back("the processor went on with the fit of the field: " + trouble);
  if (pipeline.kept_out() > 0)
    record.notes.push_back(fmt::format(
        "{} frame(s) kept out of the fit: exposure not proved, or pixels damaged", pipeline.kept_out()));
}

// Asks the source for another cycle where the fit expects less error of it.
void ask_for_exposures(CycleChoice& choice, const FrameEstimate& estimate, const SensorModel& sensor,
                       FrameSource& source, FrameRecord& record) {
  Stopwatch watch;
  const auto wish = choice.observe(estimate, {sensor.response(), sensor.noise(), sensor.reference_gain()});
  record.stages_ms.push_back({name(Stage::Exposures), watch.lap_ms()});
  record.total_ms += (record.stages_ms.end() - 1)->value;
  if (!wish) return;
  source.follow(wish->cycle);
  record.note += fmt::format("{}asked for {}", record.note.empty() ? "" : "; ", describe(*wish));
}

void close_record(RunPace pace, double wall_s, RunRecord& record) {
  const std::size_t most = frames_kept(pace);
  if (record.frames.size() == most)  // the oldest first
    std::rotate(
        record.frames.begin(),
        record.frames.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(record.emitted) % most),
        record.frames.end());
  if (static_cast<int>(record.frames.size()) < record.emitted)
    record.notes.push_back(fmt::format("times are those of the last {} frames", record.frames.size()));
  record.dropped = record.captured - record.emitted;
  record.wall_s = wall_s;
  record.peak_memory_mib = peak_memory_mib();
}

std::string folder_of_frames(const Settings& settings) {
  const std::string folder = std::filesystem::path(settings.output.path("frames")).parent_path().string();
  return folder.empty() ? "." : folder;
}

Result<void> add_scores(const RunPlan& plan, Storage& storage, RunRecord& record) {
  if (plan.truth.empty()) return {};
  const ClipScores scores =
      TRY(score_clip(storage, plan.truth, folder_of_frames(plan.settings), {.stop = plan.stop}));
  record.scores.push_back({"PSNR-mu", "dB", scores.mean.psnr_mu_db, true});
  record.scores.push_back({"PSNR-mu, worst frame", "dB", scores.worst.picture.psnr_mu_db, true});
  if (scores.mean.psnr_mu_moving_db)
    record.scores.push_back({"PSNR-mu, moving objects", "dB", *scores.mean.psnr_mu_moving_db, true});
  if (scores.flicker_stops)
    record.scores.push_back({"flicker", "stops per frame", *scores.flicker_stops, false});
  if (scores.novel_psnr_mu_db)
    record.scores.push_back({"PSNR-mu, novel view", "dB", *scores.novel_psnr_mu_db, true});
  record.scores.push_back({"phase pumping", "stops", scores.phase_stops, false});
  return {};
}

bool exists(const std::string& path, Storage& storage) {
  auto facts = storage.look_at(path);
  return facts && facts->kind != FileKind::Missing;
}

// One line for each output that is whole: where it is, and how many frames. Of numbered frames each is a file
// of its own, so that those before a failure count.
std::string written(const RunPlan& plan, const SinkSet& sinks, const RunRecord& record, Storage& storage) {
  std::string text;
  for (const SinkKind& kind : plan.sinks) {
    const std::string& path = plan.settings.output.path(kind.name);
    const auto sink = std::ranges::find(record.sinks, std::string_view(kind.name), &SinkTimes::name);
    const bool files = kind.target != SinkTarget::Address && path != kStandardOutput;
    if (path.empty() || !files || sink == record.sinks.end()) continue;
    const bool numbered = path.find('%') != std::string::npos;
    const bool some = sink->frames + sink->left_out > 0;
    if (numbered ? !some : !sinks.is_whole(kind.name) || !exists(path, storage)) continue;
    text += numbered ? fmt::format("{}: {} frames", path, sink->frames) : path;
    if (numbered && sink->left_out > 0) text += fmt::format(", {} left out to keep up", sink->left_out);
    text += '\n';
  }
  return text;
}

// If the stream ended early, that error explains why it is too short.
Result<void> first_cause(Result<void> worked, Result<void> ended) {
  const bool too_short = !worked && worked.error().code == ErrorCode::TooShort;
  if (!worked && !(too_short && !ended)) return worked;
  return ended;
}

std::optional<double> loss_of(const FrameRecord& record) {
  return record.losses.empty() ? std::nullopt : std::optional(record.losses.front().value);
}

// The path of a frame. where: a list of the outputs, for the user.
Result<void> frames_flow(const RunPlan& plan, FrameSource& source, Storage& storage, SharedProgress& progress,
                         std::string& where) {
  const Settings& settings = plan.settings;
  TRY(check_needs(settings));
  const CameraFacts& camera = source.camera();
  const RunPace pace = source.pace();
  const std::optional<ChannelGains> balance =
      TRY(white_balance_gains(parse_white_balance(settings.output.white_balance).value(), camera));

  // The method and the sinks.
  const bool field_is_seen = !plan.truth.empty() || plan.film != nullptr;
  const FieldUse use = field_is_seen ? FieldUse::Seen : FieldUse::Fills;
  const PipelineOptions options = options_of(settings, use);
  WorkerPool pool(thread_count(settings.fit),
                  pace == RunPace::Camera ? ThreadPriority::Background : ThreadPriority::Usual);
  const Backend backend = open_backend(settings.fit.backend);
  Pipeline pipeline(options, camera, pool, backend.gpu.get());
  pipeline.set_trace(plan.trace);
  CameraFacts filming = camera;  // the camera that the sinks see
  if (plan.film != nullptr) filming.framerate_hz = plan.film->framerate_hz;
  SinkSet sinks =
      TRY(SinkSet::open(plan.sinks, settings.output.paths,
                        {"", filming, settings.output.layers, compression_of(settings.output, pace),
                         settings.video, storage, settings.output.http_token, source.control(), plan.trace},
                        pace));
  std::optional<NovelViews> novel_views;
  if (!plan.truth.empty())
    novel_views = TRY(NovelViews::open(storage, plan.truth, folder_of_frames(settings), pool));
  std::optional<VirtualCamera> film;
  if (plan.film != nullptr) film.emplace(*plan.film, pool);
  std::optional<Governor> governor = governor_of(plan, options, use, camera, pace,
                                                 sinks.has_previews() ? PreviewUse::Some : PreviewUse::None);
  RunRecord record = opened_record(plan, camera, pace, pool.threads());
  if (governor) record.deadline_ms = governor->deadline_ms();
  const auto backlog = [&] {
    return is_pace_of(camera, governor->deadline()) ? source.backlog() : Backlog::Unknown;
  };
  Stopwatch wall;

  // The exposures that the fit asks for, of a camera that lets it.
  std::optional<CycleChoice> exposures;
  if (const auto room = source.exposure_room()) exposures.emplace(*room);

  // Output: each HDR frame goes to the sinks, and its record is kept.
  std::size_t responses_told = camera.linear ? 1 : 0;
  const auto stopped_film = [&]() -> Result<void> {
    if (plan.stop == nullptr || !*plan.stop || film->done()) return {};
    return Error{ErrorCode::Interrupted, fmt::format("stopped after {} of {} frames of the film; they are "
                                                     "complete",
                                                     film->shown(), plan.film->frames)};
  };
  Stopwatch between_shows;
  const VirtualCamera::Show show = [&](HdrFrame& hdr, const ExposedFrame& input,
                                       const FrameRecord& made) -> Result<void> {
    if (balance) apply_white_balance(*balance, hdr);
    TRY(sinks.emit({hdr, input, made}));
    progress.frame_done(between_shows.lap_ms(), std::nullopt);
    return stopped_film();
  };
  const Pipeline::Deliver deliver = [&](HdrFrame& hdr, const FrameEstimate& estimate,
                                        const FrameRecord& made) -> Result<void> {
    FrameRecord& kept = keep(made, pace, record);
    if (governor) kept.rung = governor->rung();
    source.emitted(kept);
    Stopwatch watch;
    const bool previews = !governor || governor->previews();
    const TraceSpan span(plan.trace, "deliver", static_cast<std::int64_t>(hdr.facts.sequence));
    if (balance && !film) apply_white_balance(*balance, hdr);
    if (film)
      TRY(film->take(hdr, estimate, pipeline.online().sensor().response(), show));
    else
      TRY(sinks.emit({hdr, estimate.frame, kept}, previews ? Previews::Written : Previews::LeftOut));
    if (!sinks.empty()) {
      const double ms = watch.lap_ms();
      kept.stages_ms.push_back({name(Stage::Sinks), ms});
      kept.total_ms += ms;
    }
    if (const std::size_t known = 1 + pipeline.online().sensor().relearned().size();
        std::exchange(responses_told, known) < known)
      source.learn_response(pipeline.online().sensor().response().inverse(1),
                            pipeline.online().sensor().black_level());
    if (exposures) ask_for_exposures(*exposures, estimate, pipeline.online().sensor(), source, kept);
    if (novel_views) TRY(novel_views->render(estimate));
    if (!film) progress.frame_done(kept.total_ms, loss_of(kept));
    return {};
  };

  pipeline.set_left_out([&] { ++record.left_out, source.left_out(); });

  // Input: frame by frame, until the source ends. The time of a frame decides on the budget of the next.
  TRY(source.start());
  const auto take_all = [&]() -> Result<void> {
    const RawFrame* frame = nullptr;
    while (!(film && film->done()) && (frame = TRY(source.next())) != nullptr) {
      ++record.captured;
      const TraceSpan span(plan.trace, "frame", static_cast<std::int64_t>(frame->facts.sequence));
      TRY(pipeline.take(*frame, governor ? governor->next() : options.knobs.budget, deliver));
      if (governor) governor->done(pipeline.work(), backlog());
    }
    TRY(pipeline.finish(deliver));
    if (!film) return {};
    TRY(stopped_film());  // what was not read is not filmed
    return film->finish(show);
  };
  Result<void> worked = take_all();

  // The end: completes the files, then writes the outputs about the whole run.
  if (const Result<void> completed = sinks.finish(); worked && !completed) worked = completed;
  if (!backend.note.empty()) record.notes.push_back(backend.note);
  if (governor) add_deadline(*governor, record);
  add_findings(pipeline, record);
  if (exposures) record.notes.push_back(exposures->summary());
  if (film)
    record.notes.push_back(fmt::format("film: {} frames; {:.1f} % of their pixels filled by the field",
                                       film->shown(), 100 * film->filled_share()));
  close_record(pace, wall.lap_ms() / 1e3, record);
  const Result<void> ended = source.finish(record);
  if (worked && ended) worked = add_scores(plan, storage, record);
  record.sinks = sinks.times();
  if (const Result<void> concluded = sinks.conclude(record); worked && !concluded) worked = concluded;
  where = written(plan, sinks, record, storage);
  if (plan.record != nullptr) *plan.record = std::move(record);
  return first_cause(std::move(worked), ended);
}

std::vector<EarlierFrames> earlier_frames(const RunPlan& plan, Storage& storage) {
  std::vector<EarlierFrames> earlier;
  for (const SinkKind& kind : plan.sinks)
    if (kind.extension != nullptr) earlier.emplace_back(storage, plan.settings.output.path(kind.name));
  return earlier;
}

// Rewrites the line that says how far the run is until the work is done.
void show_progress(std::FILE* stream, FrameSource& source, const SharedProgress& progress,
                   const std::future<Result<void>>& work) {
  constexpr auto kLook = std::chrono::milliseconds(20);
  StatusLine line(stream);
  ProgressState shown;
  while (work.wait_for(kLook) != std::future_status::ready) {
    const ProgressState now = progress.now();
    if (now.done == shown.done && source.pace() == RunPace::Clip) continue;  // a camera's line keeps changing
    if (line.due()) line.show(source.status(shown = now));
  }
  if (const ProgressState last = progress.now(); last.done > shown.done) line.show(source.status(last));
}

}  // namespace

Result<void> run(const RunPlan& plan, FrameSource& source, Storage& storage) {
  SharedProgress progress(plan.film != nullptr ? plan.film->frames : source.frame_count());
  const std::vector<EarlierFrames> earlier = earlier_frames(plan, storage);
  std::string where;
  std::future<Result<void>> work = std::async(std::launch::async, [&] {
    name_this_thread("fit");
    if (source.pace() == RunPace::Camera) set_priority_of_this_thread(ThreadPriority::Background);
    flush_denormals();
    return frames_flow(plan, source, storage, progress, where);
  });
  if (plan.progress != nullptr) show_progress(plan.progress, source, progress, work);
  Result<void> ended = work.get();
  for (const EarlierFrames& frames : earlier)
    if (const std::string warning = frames.warning(); !warning.empty()) remark("warning: {}\n", warning);
  if (plan.progress == nullptr) return ended;
  const bool taken = plan.settings.output.path("frames") == kStandardOutput;  // by the frames
  (taken ? write_remark : write_result)(where);
  return ended;
}

}  // namespace hdrcam
