#include "firmware_host/run/snapshot_film.h"

#include <future>
#include <optional>
#include <utility>

#include "firmware_host/film/virtual_camera.h"
#include "firmware_host/run/backend.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/run/progress.h"
#include "firmware_host/run/record_keeping.h"
#include "firmware_host/run/run_sinks.h"
#include "firmware_host/sinks/earlier_frames.h"
#include "hal/core/cpu.h"
#include "hal/core/stopwatch.h"
#include "hal/core/thread_name.h"

namespace hdrcam {
namespace {

class SnapshotFilm {
 public:
  // All outlives the film.
  SnapshotFilm(const RunPlan& plan, SceneSnapshot& scene, const std::optional<ChannelGains>& white_balance,
               Storage& storage)
      : plan_(plan),
        scene_(scene),
        storage_(storage),
        pool_(thread_count(plan.settings.fit), ThreadPriority::Usual),
        film_(*plan.film, white_balance, pool_),
        most_records_(frames_kept(plan, RunPace::Clip)),
        record_(opened_record(plan, scene.camera, RunPace::Clip, pool_.threads())) {
    if (plan.progress != nullptr) progress_.emplace(plan.progress, plan.film->frames);
  }

  // where: a list of the outputs, for the user.
  Result<void> to_end(const std::string& note, std::string& where) {
    sinks_ = TRY(open_sinks(plan_, scene_.camera, RunPace::Clip, nullptr, storage_));
    Stopwatch wall;
    film_.take(scene_);
    between_shows_ = {};
    Result<void> worked = fed_by([this] { return film(); }, sinks_);
    if (const Result<void> completed = sinks_.finish(); !is_failure(worked) && !completed) worked = completed;
    if (!note.empty()) record_.notes.push_back(note);
    add_findings(film_, record_);
    record_.response = curves_of(*scene_.response);
    close_record(most_records_, wall.lap_ms() / 1e3, record_);
    record_.sinks = sinks_.times();
    if (const Result<void> concluded = sinks_.conclude(record_); !is_failure(worked) && !concluded)
      worked = concluded;
    where = sinks_.whole_outputs(storage_);
    if (plan_.record != nullptr) *plan_.record = std::move(record_);
    return worked;
  }

 private:
  Result<void> film() {
    return film_.finish([this](HdrFrame& hdr, const ExposedFrame& input, const FrameRecord& made) {
      return show(hdr, input, made);
    });
  }

  Result<void> show(HdrFrame& hdr, const ExposedFrame& input, const FrameRecord& made) {
    ++record_.captured;
    FrameRecord& kept = keep(made, most_records_, record_);
    TRY(sinks_.emit({hdr, input, made}));
    kept.total_ms = between_shows_.lap_ms();
    if (progress_) progress_->frame_done(kept.total_ms, std::nullopt);
    return check_not_stopped(plan_, film_);
  }

  const RunPlan& plan_;
  SceneSnapshot& scene_;
  Storage& storage_;
  WorkerPool pool_;
  VirtualCamera film_;
  SinkSet sinks_;
  const std::size_t most_records_;
  RunRecord record_;
  std::optional<Progress> progress_;  // none where nobody looks
  Stopwatch between_shows_;
};

Result<void> load_and_film(const RunPlan& plan, const std::string& snapshot, Storage& storage,
                           std::string& where) {
  const Backend backend = open_backend(plan.settings.fit.backend);
  SceneSnapshot scene = TRY(load_scene(storage, snapshot, backend.gpu.get()));
  const std::optional<ChannelGains> white_balance = TRY(white_balance_of(plan.settings.output, scene.camera));
  SnapshotFilm film(plan, scene, white_balance, storage);
  return film.to_end(backend.note, where);
}

}  // namespace

Result<void> film_snapshot(const RunPlan& plan, const std::string& snapshot, Storage& storage) {
  const std::vector<EarlierFrames> earlier = earlier_frames(storage, plan.sinks, plan.settings.output.paths);
  std::string where;
  // of its own, because numbers are rounded there as in a run
  std::future<Result<void>> work = std::async(std::launch::async, [&] {
    name_this_thread("film");
    flush_denormals();
    return load_and_film(plan, snapshot, storage, where);
  });
  Result<void> ended = work.get();
  tell_of_outputs(plan, earlier, where);
  return ended;
}

}  // namespace hdrcam
