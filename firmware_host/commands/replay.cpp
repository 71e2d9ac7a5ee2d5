// hdrcam replay RECORDING -o out/%06d.exr: the main job, from a recording instead of a sensor.
#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "firmware_host/commands/command.h"
#include "firmware_host/pipeline.h"
#include "firmware_host/progress.h"
#include "firmware_host/sinks/contact_sheet.h"
#include "firmware_host/sinks/exr_sequence.h"
#include "firmware_host/sinks/preview.h"
#include "firmware_host/sinks/report.h"
#include "hal/core/cpu.h"
#include "render/scores/scores.h"

namespace hdrcam {
namespace {

struct ReplayFlags {
  std::string recording, output, preset = "balanced", emit = "merged", layers, compression = "zip";
  std::string preview, sheet, stats, report, truth;
  int look_ahead = -1, threads = 0, frames = 0;
  std::uint64_t seed = 1;
  double code_noise = 1;
};

// Where the emitted frames of a run go.
struct Sinks {
  std::vector<std::unique_ptr<FrameSink>> files;
  std::unique_ptr<ContactSheet> sheet;

  Result<void> emit(const HdrFrame& frame, const ExposedFrame& input) {
    if (sheet) {
      sheet->saw_input(input.facts, input.codes);
      TRY(sheet->emit(frame));
    }
    for (auto& sink : files) TRY(sink->emit(frame));
    return {};
  }
  Result<void> finish() {
    if (sheet) TRY(sheet->finish());
    for (auto& sink : files) TRY(sink->finish());
    return {};
  }
};

Result<Sinks> open_sinks(const ReplayFlags& flags, const CameraFacts& camera, Storage& storage) {
  Sinks sinks;
  if (!flags.output.empty()) {
    ExrSequenceOptions options;
    options.layers = TRY(parse_layers(flags.layers));
    options.compression = flags.compression == "piz" ? ExrCompression::Piz : ExrCompression::Zip;
    options.framerate_hz = camera.framerate_hz;
    sinks.files.push_back(TRY(create_exr_sequence(storage, flags.output, options)));
  }
  if (!flags.preview.empty()) sinks.files.push_back(TRY(create_preview(storage, flags.preview)));
  if (!flags.sheet.empty() || !flags.report.empty())
    sinks.sheet = std::make_unique<ContactSheet>(storage, flags.sheet);
  return sinks;
}

Result<void> make_folder_of(Storage& storage, const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  if (path.empty() || folder.empty()) return {};
  return storage.make_directories(folder.string());
}

std::string command_line_of(const ReplayFlags& flags) {
  std::string text = fmt::format("hdrcam replay {}", flags.recording);
  if (!flags.output.empty()) text += fmt::format(" -o {}", flags.output);
  text += fmt::format(" --preset {} --emit {}", flags.preset, flags.emit);
  if (flags.look_ahead >= 0) text += fmt::format(" --lookahead {}", flags.look_ahead);
  if (flags.frames > 0) text += fmt::format(" --frames {}", flags.frames);
  return text + fmt::format(" --seed {}", flags.seed);
}

RunRecord begin_record(const ReplayFlags& flags, const CameraFacts& camera, int threads) {
  RunRecord record;
  record.title = camera.name.empty() ? std::filesystem::path(flags.recording).stem().string() : camera.name;
  record.command = command_line_of(flags);
  record.preset = flags.preset;
  record.seed = flags.seed;
  record.threads = threads;
  record.camera = camera.name;
  record.width = camera.width, record.height = camera.height;
  record.framerate_hz = camera.framerate_hz;
  return record;
}

// What is known of the clip only at its end.
void conclude_record(RunRecord& record, const OnlineStage& online, double wall_s) {
  record.emitted = static_cast<int>(record.frames.size());
  record.dropped = record.captured - record.emitted;
  record.wall_s = wall_s;
  record.peak_memory_mib = peak_memory_mib();
  record.response = ResponseCurves{online.response().inverse(0), online.response().inverse(1),
                                   online.response().inverse(2)};
  record.response_prior = prior_mean_response().inverse(1);
  const NoiseModel& noise = online.noise();
  record.notes.push_back(fmt::format("noise: full well {:.0f} electrons, read noise {:.1f} electrons",
                                     noise.full_well, noise.read_noise));
  const BlackLevel& black = online.black_level();
  record.notes.push_back(
      fmt::format("black level: {:.1f}, {:.1f}, {:.1f} codes of 255", black[0], black[1], black[2]));
}

Result<void> add_scores(RunRecord& record, const ReplayFlags& flags, Surroundings& around) {
  if (flags.truth.empty()) return {};
  const std::string folder = std::filesystem::path(flags.output).parent_path().string();
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
  const Preset preset = TRY(parse_preset(flags.preset));
  const EmitLayer layer = TRY(parse_layer(flags.emit));
  if (!flags.truth.empty() && flags.output.empty())
    return Error{ErrorCode::Invalid, "--truth scores the HDR frames on disk; give --output too"};
  auto reader = TRY(open_recording(around.storage, flags.recording));
  const CameraFacts& camera = reader->camera();
  const int threads =
      flags.threads > 0 ? flags.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  PipelineOptions options = options_of(preset, layer);
  if (options.online.field) options.online.field->field.seed = flags.seed;
  if (flags.look_ahead >= 0) options.online.look_ahead = flags.look_ahead;
  options.online.code_noise = static_cast<float>(flags.code_noise);

  for (const std::string* path : {&flags.stats, &flags.report, &flags.sheet})
    TRY(make_folder_of(around.storage, *path));
  Sinks sinks = TRY(open_sinks(flags, camera, around.storage));
  flush_denormals();
  WorkerPool pool(threads);
  auto pipeline = TRY(Pipeline::create(options, camera, pool));
  RunRecord record = begin_record(flags, camera, threads);
  std::optional<int> total = reader->frame_count();
  if (flags.frames > 0) total = total ? std::min(*total, flags.frames) : flags.frames;
  const auto start = std::chrono::steady_clock::now();

  std::optional<Error> ended_early;  // reported after everything that was done is safe on disk
  {
    Progress progress(stderr, total);
    const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const ExposedFrame& input,
                                          const FrameRecord& facts) -> Result<void> {
      TRY(sinks.emit(frame, input));
      record.frames.push_back(facts);
      progress.frame_done(facts.total_ms,
                          facts.losses.empty() ? std::nullopt : std::optional(facts.losses.front().value));
      return {};
    };
    while (flags.frames == 0 || record.captured < flags.frames) {
      if (around.stop) {
        ended_early = Error{ErrorCode::Interrupted,
                            fmt::format("stopped after {} frames; they are complete", record.captured)};
        break;
      }
      auto next = reader->next();
      if (!next && next.error().code == ErrorCode::Truncated && record.captured > 0) {
        ended_early = next.error();
        break;
      }
      const std::optional<RawFrame> raw = TRY(std::move(next));
      if (!raw) break;
      TRY(pipeline->take(*raw, deliver));
      ++record.captured;
    }
    auto finished = pipeline->finish(deliver);
    const bool stopped_too_soon = ended_early && !finished && finished.error().code == ErrorCode::TooShort;
    if (!finished && !stopped_too_soon) return finished;
  }
  TRY(sinks.finish());
  conclude_record(record, pipeline->online(),
                  std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  if (!ended_early) TRY(add_scores(record, flags, around));
  if (!flags.stats.empty()) TRY(write_stats(around.storage, flags.stats, record));
  if (!flags.report.empty()) TRY(write_report(around.storage, flags.report, record, sinks.sheet->png()));
  if (ended_early) return *ended_early;
  return {};
}

}  // namespace

void add_replay(CLI::App& app, Verb& chosen) {
  auto flags = std::make_shared<ReplayFlags>();
  CLI::App* verb = app.add_subcommand("replay", "turn a recording into HDR frames");
  verb->add_option("recording", flags->recording, "the recording (docs/recording.md)")->required();
  verb->add_option("-o,--output", flags->output,
                   "HDR frames, numbered by the sensor's sequence: out/%06d.exr");
  verb->add_option("--preset", flags->preset, "fast, balanced or best: quality against time")
      ->capture_default_str();
  verb->add_option("--emit", flags->emit, "merged, or one layer alone: state, field")->capture_default_str();
  verb->add_option("--lookahead", flags->look_ahead, "later frames that an HDR frame waits for, 0..2 [1]")
      ->check(CLI::Range(0, 2));
  verb->add_option("--frames", flags->frames, "stop after so many frames")->check(CLI::PositiveNumber);
  verb->add_option("--threads", flags->threads, "worker threads [all processors]")->check(CLI::Range(1, 256));
  verb->add_option("--seed", flags->seed, "of the fit's random rays")->capture_default_str();
  verb->add_option("--code-noise", flags->code_noise, "rms of compression noise, codes: 1 clean, 2 MJPEG")
      ->check(CLI::Range(0., 20.))
      ->capture_default_str();
  verb->add_option("--layers", flags->layers, "further EXR channels: depth,flow,confidence,provenance");
  verb->add_option("--compression", flags->compression, "of the EXR files: zip or piz")
      ->check(CLI::IsMember({"zip", "piz"}))
      ->capture_default_str();
  verb->add_option("--preview", flags->preview, "tone-mapped pictures: out/%06d.png");
  verb->add_option("--sheet", flags->sheet, "contact sheet of the run: sheet.png");
  verb->add_option("--stats", flags->stats, "time, losses and provenance per frame: stats.json");
  verb->add_option("--report", flags->report, "all of that on one page: report.html");
  verb->add_option("--truth", flags->truth, "a clip with ground truth: adds scores to the report");
  verb->callback(
      [flags, &chosen] { chosen = [flags](Surroundings& around) { return replay(*flags, around); }; });
}

}  // namespace hdrcam
