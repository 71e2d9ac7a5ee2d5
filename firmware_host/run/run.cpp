#include "firmware_host/run/run.h"

#include <fmt/format.h>

#include <future>
#include <optional>
#include <string>
#include <utility>

#include "firmware_host/film/scene_keeper.h"
#include "firmware_host/film/virtual_camera.h"
#include "firmware_host/run/backend.h"
#include "firmware_host/run/deadline.h"
#include "firmware_host/run/governor.h"
#include "firmware_host/run/novel_views.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/run/pipeline.h"
#include "firmware_host/run/progress.h"
#include "firmware_host/run/record_keeping.h"
#include "firmware_host/run/run_sinks.h"
#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/terminal.h"
#include "hal/core/counted.h"
#include "hal/core/cpu.h"
#include "hal/core/stopwatch.h"
#include "hal/core/thread_name.h"
#include "online/exposure/cycle_choice.h"
#include "render/white_balance.h"

namespace hdrcam {
namespace {

// What a run tells of its end, beside its first error.
struct RunEnding {
  std::string where;           // a list of the outputs
  std::optional<Error> other;  // of the source's end, such as a cut recording, or of what comes behind
};

// A later failure is told beside the first.
Result<void> first_failure(Result<void> first, Result<void> later, RunEnding& told) {
  if (first || (!is_failure(first) && is_failure(later))) return later;
  if (is_failure(later) && !told.other && later.error().message != first.error().message)
    told.other = later.error();
  return first;
}

// If the stream ended early, that error explains why it is too short.
Result<void> first_cause(Result<void> worked, Result<void> ended, RunEnding& told) {
  const bool too_short = !worked && worked.error().code == ErrorCode::TooShort;
  return too_short && !ended ? ended : first_failure(std::move(worked), std::move(ended), told);
}

std::optional<double> loss_of(const FrameRecord& record) {
  return record.losses.empty() ? std::nullopt : std::optional(record.losses.front().value);
}

// What the run itself did with a frame, behind the pipeline.
void add_stage(Stage stage, double ms, FrameRecord& kept) {
  kept.stages_ms.push_back({name(stage), ms});
  kept.total_ms += ms;
}

// The path of a frame: from the source through the method to the outputs.
class Run {
 public:
  // white_balance: of the HDR frames; none: as the sensor gives them. All else outlives the run.
  Run(const RunPlan& plan, const std::optional<ChannelGains>& white_balance, FrameSource& source,
      Storage& storage, SharedProgress& progress);

  Result<void> to_end(RunEnding& told);

 private:
  Result<void> open_outputs();
  void open_governor();
  Result<void> take_frames();
  Result<void> conclude(Result<void> worked, Stopwatch wall, RunEnding& told);
  Result<void> save_scene();

  Result<void> deliver(HdrFrame& hdr, const FrameEstimate& estimate, const FrameRecord& made);
  Result<void> give_to_outputs(HdrFrame& hdr, const FrameEstimate& estimate, FrameRecord& kept);
  void tell_response();
  void ask_for_exposures(const FrameEstimate& estimate, FrameRecord& kept);
  Result<void> show(HdrFrame& hdr, const ExposedFrame& input, const FrameRecord& made);

  const SensorModel& sensor() const { return pipeline_.online().sensor(); }
  Backlog backlog() const;

  const RunPlan& plan_;
  const std::optional<ChannelGains> white_balance_;
  FrameSource& source_;
  Storage& storage_;
  const EarlierEstimates earlier_;
  SharedProgress& progress_;
  const CameraFacts& camera_;
  const RunPace pace_;
  const std::size_t most_records_;
  const FieldUse use_;
  const PipelineOptions options_;
  WorkerPool pool_;
  const Backend backend_;
  Pipeline pipeline_;
  SinkSet sinks_;
  std::optional<NovelViews> novel_views_;
  std::optional<SceneKeeper> scene_;  // that is saved at the end
  std::optional<VirtualCamera> film_;
  const VirtualCamera::Show show_;     // a film frame to the sinks
  std::optional<Governor> governor_;   // none without a deadline
  std::optional<CycleChoice> choice_;  // of the exposures, of a camera that lets the fit ask for them
  RunRecord record_;
  std::size_t responses_told_;  // to the source
  Stopwatch between_shows_;
  std::string saved_;  // a line about the scene, once it is saved
};

// Films and scores look at the field, whatever the settings show of it.
FieldUse field_use_of(const RunPlan& plan, RunPace pace) {
  const bool seen =
      !plan.truth.empty() || plan.film != nullptr || sees_field_in_scene(plan.settings.output, pace);
  return seen ? FieldUse::Seen : FieldUse::Fills;
}

Run::Run(const RunPlan& plan, const std::optional<ChannelGains>& white_balance, FrameSource& source,
         Storage& storage, SharedProgress& progress)
    : plan_(plan),
      white_balance_(white_balance),
      source_(source),
      storage_(storage),
      earlier_(earlier_estimates(plan, storage)),
      progress_(progress),
      camera_(source.camera()),
      pace_(source.pace()),
      most_records_(frames_kept(plan, pace_)),
      use_(field_use_of(plan, pace_)),
      options_(options_of(plan.settings, use_)),
      pool_(thread_count(plan.settings.fit),
            pace_ == RunPace::Camera ? ThreadPriority::Background : ThreadPriority::Usual),
      backend_(open_backend(plan.settings.fit.backend)),
      pipeline_(options_, camera_, pool_, backend_.gpu.get()),
      show_([this](HdrFrame& hdr, const ExposedFrame& input, const FrameRecord& made) {
        return show(hdr, input, made);
      }),
      record_(opened_record(plan, camera_, pace_, pool_.threads())),
      responses_told_(camera_.linear ? 1 : 0) {
  pipeline_.set_trace(plan.trace);
  pipeline_.set_left_out([this] { ++record_.left_out, source_.left_out(); });
  if (plan.film != nullptr) film_.emplace(*plan.film, white_balance, pool_);
  if (plan.film == nullptr && !plan.settings.output.path(Settings::Output::kSnapshot).empty())
    scene_.emplace(options_.knobs.hash_grid.window.frames, pool_);  // what the field knows of
}

Result<void> Run::to_end(RunEnding& told) {
  TRY(open_outputs());
  open_governor();
  if (const auto limits = source_.exposure_limits()) choice_.emplace(*limits, options_.knobs.state);
  between_shows_ = {};
  Stopwatch wall;
  TRY(source_.start());
  const Result<void> worked = fed_by([this] { return take_frames(); }, sinks_);
  Result<void> ended = conclude(worked, wall, told);
  told.where = sinks_.whole_outputs(storage_) + saved_;
  if (plan_.record != nullptr) *plan_.record = std::move(record_);
  return ended;
}

Result<void> Run::open_outputs() {
  const Settings::Output& output = plan_.settings.output;
  sinks_ = TRY(open_sinks(plan_, camera_, pace_, source_.control(), storage_));
  if (scene_) TRY(scene_->name_file(storage_, output.path(Settings::Output::kSnapshot)));
  if (!plan_.truth.empty())
    novel_views_ =
        TRY(NovelViews::open(storage_, plan_.truth, camera_, folder_of(output.path(sink_name::kFrames)),
                             compression_of(output, pace_), pool_));
  return {};
}

// A film is made without a deadline: all frames of its window count.
void Run::open_governor() {
  const std::optional<Duration> deadline = deadline_of(plan_.settings.fit, camera_, pace_);
  if (!deadline || film_) return;
  FrameBudget asked = options_.knobs.budget;
  asked.later_frames = look_ahead_of(options_.knobs, camera_.height, camera_.width);
  const PreviewUse previews = sinks_.has_previews() ? PreviewUse::Some : PreviewUse::None;
  governor_.emplace(budget_ladder(asked, field_use(plan_.settings, options_, use_), previews), *deadline);
  record_.deadline_ms = governor_->deadline_ms();
}

// Input: frame by frame, until the source ends. The time of a frame decides on the budget of the next.
Result<void> Run::take_frames() {
  const Pipeline::Deliver deliver = [this](HdrFrame& hdr, const FrameEstimate& estimate,
                                           const FrameRecord& made) {
    return this->deliver(hdr, estimate, made);
  };
  const RawFrame* frame = nullptr;
  while (!(film_ && film_->done()) && (frame = TRY(source_.next())) != nullptr) {
    if (scene_ && record_.captured == 0) scene_->begin(frame->facts.timestamp);
    ++record_.captured;
    const TraceSpan span(plan_.trace, "frame", static_cast<std::int64_t>(frame->facts.sequence));
    TRY(pipeline_.take(*frame, governor_ ? governor_->next() : options_.knobs.budget, deliver));
    if (governor_) governor_->done(pipeline_.work(), backlog());
  }
  TRY(pipeline_.finish(deliver));
  if (governor_) governor_->ended(pipeline_.work().frames);
  if (!film_) return {};
  TRY(check_not_stopped(plan_, *film_));  // what was not read is not filmed
  return film_->finish(show_);
}

// Output: each HDR frame goes to the outputs and its record is kept; what the fit learned goes to the source.
Result<void> Run::deliver(HdrFrame& hdr, const FrameEstimate& estimate, const FrameRecord& made) {
  FrameRecord& kept = keep(made, most_records_, record_);
  if (governor_) kept.rung = governor_->rung();
  source_.emitted(kept);
  const TraceSpan span(plan_.trace, "deliver", static_cast<std::int64_t>(hdr.facts.sequence));
  if (film_ && plan_.film->frozen) between_shows_ = {};  // its frames come one after the other, of one moment
  TRY(give_to_outputs(hdr, estimate, kept));
  tell_response();
  if (choice_) ask_for_exposures(estimate, kept);
  if (novel_views_)
    TRY(novel_views_->render(estimate, gains_of_both(estimate.neutral_gains, white_balance_)));
  if (film_)
    progress_.frame_read(kept.total_ms);
  else
    progress_.frame_done(kept.total_ms, loss_of(kept));
  return {};
}

// To the film, which shows its own frames, or to the sinks.
Result<void> Run::give_to_outputs(HdrFrame& hdr, const FrameEstimate& estimate, FrameRecord& kept) {
  Stopwatch watch;
  if (scene_) scene_->take(hdr, estimate);
  if (film_) {
    TRY(film_->take(hdr, estimate, sensor().camera_response(), show_));
  } else {
    balance_colours(white_balance_, hdr);
    const bool previews = !governor_ || governor_->previews();
    TRY(sinks_.emit({hdr, estimate.frame, kept}, previews ? Previews::Written : Previews::LeftOut));
  }
  if (sinks_.empty() && !scene_) return {};
  add_stage(Stage::Sinks, watch.lap_ms(), kept);
  return {};
}

// Once it is estimated, and each time it is learned anew. A source that took one that no frame showed for the
// camera's would find that right exposures contradict the pictures.
void Run::tell_response() {
  if (!sensor().response_is_sure()) return;
  const std::size_t known = 1 + sensor().relearned().size();
  if (std::exchange(responses_told_, known) < known)
    source_.learn_response(sensor().camera_response().inverse(1), sensor().camera_black_level());
}

// Asks the source for another cycle where the fit expects less error of it.
void Run::ask_for_exposures(const FrameEstimate& estimate, FrameRecord& kept) {
  Stopwatch watch;
  const auto request =
      choice_->observe(estimate, {sensor().response(), sensor().noise(), sensor().reference_gain()});
  add_stage(Stage::Exposures, watch.lap_ms(), kept);
  if (!request) return;
  if (!source_.follow(request->cycle)) return;  // the cycle before goes on
  choice_->runs(*request);
  kept.note += fmt::format("{}asked for {}", kept.note.empty() ? "" : "; ", describe(*request));
}

Result<void> Run::show(HdrFrame& hdr, const ExposedFrame& input, const FrameRecord& made) {
  TRY(sinks_.emit({hdr, input, made}));
  progress_.frame_done(between_shows_.lap_ms(), std::nullopt);
  return check_not_stopped(plan_, *film_);
}

Backlog Run::backlog() const {
  return is_pace_of(camera_, governor_->deadline()) ? source_.backlog() : Backlog::Unknown;
}

// The end: completes the files, then writes the outputs about the whole run.
Result<void> Run::conclude(Result<void> worked, Stopwatch wall, RunEnding& told) {
  if (const Result<void> completed = sinks_.finish(); !is_failure(worked) && !completed) worked = completed;
  if (!backend_.note.empty()) record_.notes.push_back(backend_.note);
  if (governor_) add_deadline(*governor_, record_);
  add_findings(pipeline_, record_);
  if (choice_) record_.notes.push_back(choice_->summary());
  if (film_) add_findings(*film_, record_);
  close_record(most_records_, wall.lap_ms() / 1e3, record_);
  Result<void> outcome = first_cause(std::move(worked), source_.finish(record_), told);
  // depth and motion take their time: the camera and its recording have ended
  outcome = first_failure(std::move(outcome), save_scene(), told);
  if (outcome) outcome = add_scores(plan_, earlier_, storage_, record_);
  record_.sinks = sinks_.times();
  return first_failure(std::move(outcome), sinks_.conclude(record_), told);
}

Result<void> Run::save_scene() {
  if (!scene_ || scene_->frames() == 0) return {};
  const std::string& path = plan_.settings.output.path(Settings::Output::kSnapshot);
  const std::string frames = counted(scene_->frames(), "frame");
  TRY(scene_->save(camera_, sensor().camera_response()));
  record_.notes.push_back(fmt::format("snapshot: the scene of the last {}", frames));
  saved_ = fmt::format("{}: the scene of the last {}\n", path, frames);
  return {};
}

// What the settings rule out is found before the run is built.
Result<void> run_to_end(const RunPlan& plan, FrameSource& source, Storage& storage, SharedProgress& progress,
                        RunEnding& told) {
  TRY(check_needs(plan.settings));
  TRY(check_readout(plan.settings.fit, source.camera()));
  const std::optional<ChannelGains> white_balance =
      TRY(white_balance_of(plan.settings.output, source.camera()));
  if (const std::string note = note_on_motion(plan.settings, source.camera()); !note.empty())
    remark("note: {}\n", note);
  Run run(plan, white_balance, source, storage, progress);
  return run.to_end(told);
}

}  // namespace

Result<void> run(const RunPlan& plan, FrameSource& source, Storage& storage) {
  SharedProgress progress(plan.film != nullptr ? plan.film->frames : source.frame_count());
  std::vector<EarlierFrames> earlier = earlier_frames(storage, plan.sinks, plan.settings.output.paths);
  if (!plan.truth.empty())
    earlier.emplace_back(storage, NovelViews::files_beside(plan.settings.output.path(sink_name::kFrames)));
  RunEnding told;
  std::future<Result<void>> work = std::async(std::launch::async, [&] {
    name_this_thread("fit");
    if (source.pace() == RunPace::Camera) set_priority_of_this_thread(ThreadPriority::Background);
    flush_denormals();
    return run_to_end(plan, source, storage, progress, told);
  });
  if (plan.progress != nullptr) show_progress(plan.progress, source, progress, work);
  Result<void> ended = work.get();
  tell_of_outputs(plan, earlier, told.where);
  if (told.other) remark("warning: {}\n", told.other->message);
  return ended;
}

}  // namespace hdrcam
