// hdrcam live --camera ID -o out/%06d.exr: the main job, from a camera, as the frames come in.
#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/run_limits.h"
#include "firmware_host/live/camera_run.h"
#include "firmware_host/live/live_report.h"
#include "firmware_host/run/fit_run.h"
#include "hal/core/cpu.h"

namespace hdrcam {
namespace {

struct LiveFlags {
  RunLimits limits;
  std::unique_ptr<SettingsFlags> settings;
};

const std::vector<SettingGroup> kGroups{SettingGroup::Camera, SettingGroup::Schedule, SettingGroup::Sync,
                                        SettingGroup::Fit,    SettingGroup::Output,   SettingGroup::Record};

std::string command_line_of(const Settings& settings, const LiveFlags& flags) {
  std::string text =
      fmt::format("hdrcam live --camera {} --shutter {}", settings.camera.id, settings.schedule.shutter);
  if (!settings.output.frames.empty()) text += fmt::format(" -o {}", settings.output.frames);
  text += flags_of(settings.fit);
  return flags.limits.frames > 0 ? text + fmt::format(" --frames {}", flags.limits.frames) : text;
}

bool keeps_nothing(const Settings& settings) {
  const Settings::Output& output = settings.output;
  return output.frames.empty() && output.preview.empty() && output.sheet.empty() && output.stats.empty() &&
         output.report.empty() && settings.record.file.empty();
}

// Once the fit has found the camera's response, the proof of exposures may use it.
class ResponseReport {
 public:
  explicit ResponseReport(LiveSession& session) : session_(session) {}
  void emitted(const OnlineStage& online, bool linear) {
    if (linear || told_) return;
    told_ = true;
    session_.learn_response(online.response().inverse(1), online.black_level()[1]);
  }

 private:
  LiveSession& session_;
  bool told_ = false;
};

// The fit on a thread of its own, behind capture and recorder where there is more to do than processors. Ends
// with the run, or when the fit fails.
class FitThread {
 public:
  FitThread(LiveSession& session, FitRun& run, const std::atomic<bool>& stop)
      : thread_([this, &session, &run, &stop] {
          set_priority_of_this_thread(ThreadPriority::Background);
          flush_denormals();
          while (const FrameShare frame = session.next(stop, {}))
            if (result_ = run.take(frame->captured.raw); !result_) break;
          if (result_) result_ = run.finish();
          over_ = true;
        }) {}
  ~FitThread() {
    if (thread_.joinable()) thread_.join();
  }
  bool over() const { return over_; }
  Result<void> join() {
    thread_.join();
    return result_;
  }

 private:
  std::atomic<bool> over_{false};
  Result<void> result_;
  std::thread thread_;
};

void show_progress(const LiveSession& session, const FitThread& fit) {
  constexpr auto kLook = std::chrono::milliseconds(20);
  for (LiveStatus status(session, true); !fit.over(); std::this_thread::sleep_for(kLook)) status.update();
}

void add_counters(RunRecord& record, const LiveCounters& counters) {
  record.counters = named(counters);
  record.captured = static_cast<int>(counters.captured());
  record.emitted = static_cast<int>(counters.emitted);
  record.dropped = static_cast<int>(counters.dropped());
  record.notes.push_back(proof_of(counters.camera));
}

Result<void> live(const LiveFlags& flags, Surroundings& around) {
  const Settings settings = TRY(flags.settings->read(around.storage));
  if (flags.settings->print_config()) return fmt::print("{}", to_toml(settings, kGroups)), Result<void>{};
  const auto camera = TRY(CameraRun::open(settings, flags.limits.options(true), around.storage));
  LiveSession& session = camera->session();
  for (const std::string& warning : camera->capture().warnings()) fmt::print(stderr, "note: {}\n", warning);
  if (keeps_nothing(settings))
    fmt::print(stderr, "note: nothing of this run is kept; give -o out/%06d.exr or --record walk.mkv\n");

  ResponseReport response(session);
  std::unique_ptr<FitRun> run;
  run = TRY(FitRun::open(
      settings, camera->facts(), camera->facts().name, command_line_of(settings, flags), around.storage,
      [&](FrameRecord& frame) {
        frame.latency_ms = to_seconds(session.emitted(frame.sequence)) * 1e3;
        response.emitted(run->pipeline().online(), camera->facts().linear);
      },
      FrameSource::Camera));
  TRY(session.start());
  FitThread fit(session, *run, around.stop);
  show_progress(session, fit);
  Result<void> fitted = fit.join();
  const Result<LiveEnd> end = camera->finish();

  const LiveCounters counters = session.counters();
  add_counters(run->record(), counters);
  TRY(run->conclude());
  fmt::print("{}\n{}\nlatency: {:.0f} ms at most\n", sentence_of(counters, true), proof_of(counters.camera),
             to_seconds(counters.longest_latency) * 1e3);
  if (!settings.record.file.empty())
    fmt::print("recorded {} frames to {}\n", counters.recorded, settings.record.file);
  if (!end) return end.error();
  if (!fitted) return fitted;
  return flags.limits.ended_by(end.value(), counters.captured());
}

}  // namespace

void add_live(CLI::App& app, Verb& chosen) {
  auto flags = std::make_shared<LiveFlags>();
  CLI::App* verb = app.add_subcommand("live", "turn a camera's frames into HDR frames while they come in");
  flags->limits.add_to(*verb);
  flags->settings = std::make_unique<SettingsFlags>(*verb, kGroups);
  verb->callback(
      [flags, &chosen] { chosen = [flags](Surroundings& around) { return live(*flags, around); }; });
}

}  // namespace hdrcam
