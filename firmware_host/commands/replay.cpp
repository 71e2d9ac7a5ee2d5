// hdrcam replay RECORDING -o out/%06d.exr: the main job, from a recording instead of a sensor.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "firmware_host/commands/command.h"
#include "firmware_host/run/fit_run.h"
#include "firmware_host/run/progress.h"
#include "hal/core/cpu.h"
#include "hal/recording/recording.h"
#include "render/scores/scores.h"

namespace hdrcam {
namespace {

struct ReplayFlags {
  std::string recording, truth;
  int frames = 0;
  Settings settings;
};

std::string command_line_of(const ReplayFlags& flags) {
  std::string text = fmt::format("hdrcam replay {}", flags.recording);
  if (!flags.settings.output.frames.empty()) text += fmt::format(" -o {}", flags.settings.output.frames);
  text += flags_of(flags.settings.fit);
  if (flags.frames > 0) text += fmt::format(" --frames {}", flags.frames);
  return text;
}

Result<void> add_scores(RunRecord& record, const ReplayFlags& flags, Surroundings& around) {
  if (flags.truth.empty()) return {};
  const std::string folder = std::filesystem::path(flags.settings.output.frames).parent_path().string();
  const ClipScores scores =
      TRY(score_clip(around.storage, flags.truth, folder.empty() ? "." : folder, {.stop = &around.stop}));
  record.scores.push_back({"PSNR-mu", "dB", scores.mean.psnr_mu_db, true});
  record.scores.push_back({"PSNR-mu, worst frame", "dB", scores.worst.picture.psnr_mu_db, true});
  if (scores.mean.psnr_mu_moving_db)
    record.scores.push_back({"PSNR-mu, moving objects", "dB", *scores.mean.psnr_mu_moving_db, true});
  if (scores.flicker_stops)
    record.scores.push_back({"flicker", "stops per frame", *scores.flicker_stops, false});
  record.scores.push_back({"phase pumping", "stops", scores.phase_stops, false});
  return {};
}

Result<void> replay(const ReplayFlags& flags, Surroundings& around) {
  if (!flags.truth.empty() && flags.settings.output.frames.empty())
    return Error{ErrorCode::Invalid, "--truth scores the HDR frames on disk; give --output too"};
  auto reader = TRY(open_recording(around.storage, flags.recording));
  const CameraFacts& camera = reader->camera();
  std::optional<int> total = reader->frame_count();
  if (flags.frames > 0) total = total ? std::min(*total, flags.frames) : flags.frames;
  const std::string title =
      camera.name.empty() ? std::filesystem::path(flags.recording).stem().string() : camera.name;

  flush_denormals();
  std::optional<Error> ended_early;  // reported after everything that was done is safe on disk
  std::unique_ptr<FitRun> run;
  {
    Progress progress(stderr, total);
    run = TRY(FitRun::open(
        flags.settings, camera, title, command_line_of(flags), around.storage,
        [&](const FrameRecord& frame) {
          progress.frame_done(frame.total_ms, frame.losses.empty()
                                                  ? std::nullopt
                                                  : std::optional(frame.losses.front().value));
        },
        FrameSource::Clip));
    const int& captured = run->record().captured;
    while (flags.frames == 0 || captured < flags.frames) {
      if (around.stop) {
        ended_early = Error{ErrorCode::Interrupted,
                            fmt::format("stopped after {} frames; they are complete", captured)};
        break;
      }
      auto next = reader->next();
      if (!next && next.error().code == ErrorCode::Truncated && captured > 0) {
        ended_early = next.error();
        break;
      }
      const std::optional<RawFrame> raw = TRY(std::move(next));
      if (!raw) break;
      TRY(run->take(*raw));
    }
    const Result<void> finished = run->finish();
    const bool stopped_too_soon = ended_early && !finished && finished.error().code == ErrorCode::TooShort;
    if (!finished && !stopped_too_soon) return finished;
  }
  if (!ended_early) TRY(add_scores(run->record(), flags, around));
  TRY(run->conclude());
  if (ended_early) return *ended_early;
  return {};
}

}  // namespace

void add_replay(CLI::App& app, Verb& chosen) {
  auto flags = std::make_shared<ReplayFlags>();
  CLI::App* verb = app.add_subcommand("replay", "turn a recording into HDR frames");
  verb->add_option("recording", flags->recording, "the recording (docs/recording.md)")->required();
  Settings::Fit& fit = flags->settings.fit;
  Settings::Output& output = flags->settings.output;
  verb->add_option("-o,--output", output.frames,
                   "HDR frames, numbered by the sensor's sequence: out/%06d.exr");
  verb->add_option("--preset", fit.preset, "fast, balanced or best: quality against time")
      ->capture_default_str();
  verb->add_option("--emit", fit.emit, "merged, or one layer alone: state, field")->capture_default_str();
  verb->add_option("--lookahead", fit.lookahead, "later frames that an HDR frame waits for, 0..2")
      ->check(CLI::Range(0, 2))
      ->capture_default_str();
  verb->add_option("--frames", flags->frames, "stop after so many frames")->check(CLI::PositiveNumber);
  verb->add_option("--threads", fit.threads, "worker threads [all processors]")->check(CLI::Range(1, 256));
  verb->add_option("--seed", fit.seed, "of the fit's random rays")->capture_default_str();
  verb->add_option("--code-noise", fit.code_noise, "rms of compression noise, codes: 1 clean, 2 MJPEG")
      ->check(CLI::Range(0., 20.))
      ->capture_default_str();
  verb->add_option("--layers", output.layers, "further EXR channels: depth,flow,confidence,provenance");
  verb->add_option("--compression", output.compression, "of the EXR files: zip or piz")
      ->check(CLI::IsMember({"zip", "piz"}))
      ->capture_default_str();
  verb->add_option("--preview", output.preview, "tone-mapped pictures: out/%06d.png");
  verb->add_option("--sheet", output.sheet, "contact sheet of the run: sheet.png");
  verb->add_option("--stats", output.stats, "time, losses and provenance per frame: stats.json");
  verb->add_option("--report", output.report, "all of that on one page: report.html");
  verb->add_option("--truth", flags->truth, "a clip with ground truth: adds scores to the report");
  verb->callback(
      [flags, &chosen] { chosen = [flags](Surroundings& around) { return replay(*flags, around); }; });
}

}  // namespace hdrcam
