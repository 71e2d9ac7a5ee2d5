// hdrcam simulate SCENE -o walk.mkv: a recording of a simulated scene, and with --truth its ground truth as a
// clip that `hdrcam compare` scores against.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>

#include "capture/exposure_schedule.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/recording_name.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/run/progress.h"
#include "firmware_host/sinks/truth_folder.h"
#include "firmware_host/terminal.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/recording.h"
#include "hal/sim/effect_costs.h"
#include "hal/sim/stream_effects.h"

namespace hdrcam {
namespace {

struct SimulateFlags {
  std::string scene, output, truth, format = "rgb";
  int frames = 48, bits = 0;
  bool list = false, explain = false;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

struct Format {
  PixelLayout layout;
  int bits;
};

Result<Format> format_of(const SimulateFlags& flags) {
  const bool bayer = flags.format == "bayer";
  const int bits = flags.bits != 0 ? flags.bits : bayer ? 12 : 8;
  if (!bayer && flags.format != "rgb")
    return Error{ErrorCode::Invalid, fmt::format("--format {}: give rgb or bayer", flags.format)};
  if (bits < 8 || bits > 16) return Error{ErrorCode::Invalid, fmt::format("--bits {}: give 8 to 16", bits)};
  return Format{bayer ? PixelLayout::BayerRggb : PixelLayout::Rgb, bits};
}

// The costs of a frame: each effect, its cost, and why it is on or off.
void print_plan(const SimulatedSensor& sensor, const EffectCosts& costs, double exposure_s) {
  const Simulation& s = sensor.simulation();
  const auto line = [](std::string_view what, std::string_view on, std::string_view ms,
                       std::string_view why) { say("{:<16} {:>3} {:>8}  {}\n", what, on, ms, why); };
  const auto ms = [](double cost) { return fmt::format("{:.2f}", std::max(0.0, cost)); };
  line("effect", "on", "CPU ms", "why");
  line("(bare frame)", "", ms(costs.bare_ms), "rays, surfaces, codes");
  for (std::size_t i = 0; i < kEffects; ++i) {
    const auto effect = static_cast<Effect>(i);
    const auto cost = costs.effect_ms[i];
    line(name(effect), s.plan.on(effect) ? "yes" : "no", cost ? ms(*cost) : "-", s.plan.why(effect));
  }
  line("(whole frame)", "", ms(costs.frame_ms),
       fmt::format("{}x{}, {} exposed; processor time of all threads, +-{:.2f} ms", s.width, s.height,
                   describe(from_seconds(exposure_s)), costs.noise_ms));
}

// The frames of the clip in order, each with its scene time and its exposure.
class Timeline {
 public:
  Timeline(const Simulation& simulation, std::vector<Exposure> cycle)
      : simulation_(simulation), cycle_(std::move(cycle)), stream_(simulation) {}

  // The sequence number of the next frame that is not lost. Errors: Invalid for a scene that loses them all.
  Result<std::uint64_t> next_kept(std::uint64_t sequence) const {
    constexpr std::uint64_t kMostLost = 1'000'000;  // in a row
    const std::uint64_t end = sequence + kMostLost;
    while (stream_.loses(sequence))
      if (++sequence == end)
        return Error{ErrorCode::Invalid,
                     fmt::format("drops={}: the scene loses {} frames in a row and nothing "
                                 "arrives; give drops below 1, such as drops=0.1",
                                 simulation_.drops.probability, kMostLost)};
    return sequence;
  }
  // Scene time of the middle of the picture and of its exposure.
  double centre_s(std::uint64_t sequence) const {
    return static_cast<double>(sequence) / simulation_.framerate_hz;
  }
  Shot shot(std::uint64_t sequence) const {
    const Exposure& exposure = cycle_[sequence % cycle_.size()];
    const double exposure_s = to_seconds(exposure.time);
    return {sequence, centre_s(sequence) - (exposure_s + readout_s()) / 2, exposure_s, exposure.gain};
  }
  double readout_s() const { return to_seconds(simulation_.readout()); }
  FrameFacts facts(std::uint64_t sequence, bool after_drop, int bits) const {
    const Exposure& exposure = cycle_[sequence % cycle_.size()];
    FrameFacts facts;
    facts.sequence = sequence;
    facts.timestamp =
        Instant{stream_.host_time(from_seconds(centre_s(sequence))) + stream_.latency(sequence)};
    facts.exposure_s = to_seconds(exposure.time);
    facts.readout_s = readout_s();
    facts.analogue_gain = exposure.gain;
    facts.slot = static_cast<int>(sequence % cycle_.size());
    if (simulation_.black_level > 0)
      facts.black_level = BlackLevel::of_code(
          static_cast<double>(simulation_.black_level * static_cast<float>((1 << bits) - 1)), bits);
    if (after_drop) facts.flags |= kFrameAfterDrop;
    return facts;
  }
  double longest_s() const {
    Duration longest{};
    for (const Exposure& exposure : cycle_) longest = std::max(longest, exposure.time);
    return to_seconds(longest);
  }

 private:
  const Simulation& simulation_;
  std::vector<Exposure> cycle_;
  StreamEffects stream_;
};

// All files that the run writes, those of the truth first.
std::vector<NamedOutput> outputs_of(const SimulateFlags& flags) {
  std::vector<NamedOutput> outputs;
  const auto add = [&](const std::string& file, OutputKind kind) {
    outputs.push_back({"--truth", flags.truth + "/" + file, kind});
  };
  if (!flags.truth.empty()) {
    const std::string truth = std::string(TruthFolder::kFolder) + "/";
    add(ImageSequence::kFile, OutputKind::Document);
    for (const char* file : TruthFolder::kFiles) add(truth + file, OutputKind::Document);
    add(std::string(ImageSequence::kPictures) + "/%04d.png", OutputKind::Frames);
    for (const char* frames : TruthFolder::kFrames) add(truth + frames, OutputKind::Frames);
  }
  outputs.push_back({"--output", flags.output, OutputKind::Recording});
  return outputs;
}

// The outputs of a run; each exists if it was requested.
struct Outputs {
  std::unique_ptr<RecordingWriter> recording;
  std::optional<ImageSequenceWriter> clip;
  std::optional<TruthFolder> truth;
};

Result<Outputs> open_outputs(Surroundings& around, const SimulateFlags& flags, const SimulatedSensor& sensor,
                             RecordingCodec codec) {
  Outputs outputs;
  CameraFacts facts = sensor.facts();
  if (!flags.truth.empty()) {
    outputs.clip = TRY(ImageSequenceWriter::create(around.storage, flags.truth, facts, Creation::Replace));
    outputs.truth = TRY(TruthFolder::create(around.storage, flags.truth, sensor, flags.scene));
  }
  // last, so that a refused run never empties an earlier recording
  if (!flags.output.empty())
    outputs.recording = TRY(create_recording(around.storage, flags.output, facts, Creation::Replace, codec));
  return outputs;
}

// Completes the outputs of a run with so many frames; without any they stay as they are.
Result<void> finish(const SimulateFlags& flags, const SimulatedSensor& sensor, int frames, Outputs& outputs) {
  if (frames == 0) return {};
  if (outputs.recording) {
    TRY(outputs.recording->finish());
    say("{}\n", describe_recording(flags.output, sensor.facts(), static_cast<std::uint64_t>(frames)));
  }
  if (outputs.truth) {
    TRY(outputs.truth->finish());
    TRY(outputs.clip->finish());
    say("{}: a clip of {} images with ground truth\n", flags.truth, frames);
  }
  return {};
}

Error stopped_before_any() { return {ErrorCode::Interrupted, "stopped before the first frame"}; }

Result<void> film(Surroundings& around, const SimulateFlags& flags, const Timeline& timeline,
                  SimulatedSensor& sensor, WorkerPool& pool, Outputs& outputs) {
  const Simulation& s = sensor.simulation();
  std::optional<TruthRenderer> truth_renderer;
  if (outputs.truth)
    truth_renderer.emplace(*sensor.scene(), sensor.lens(), s.height, s.width, pool, sensor.vignetting());
  Progress progress(stderr, flags.frames);
  SceneTruth truth;
  RawFrame frame;
  std::uint64_t sequence = TRY(timeline.next_kept(0)), before = sequence;
  for (int i = 0; i < flags.frames; ++i) {
    if (around.stop) {
      TRY(finish(flags, sensor, i, outputs));
      return i == 0 ? stopped_before_any()
                    : Error{ErrorCode::Interrupted,
                            fmt::format("stopped after {} of {} frames; they are complete", i, flags.frames)};
    }
    const auto begin = std::chrono::steady_clock::now();
    sensor.expose(timeline.shot(sequence), frame.codes);
    frame.facts = timeline.facts(sequence, i > 0 && sequence != before + 1, sensor.facts().bits);
    const std::uint64_t next = TRY(timeline.next_kept(sequence + 1));
    if (outputs.recording) TRY(outputs.recording->append(frame));
    if (outputs.truth) {
      truth_renderer->render(timeline.centre_s(sequence), timeline.centre_s(next), truth);
      TRY(outputs.clip->append(frame));
      TRY(outputs.truth->append(truth, frame.facts));
    }
    before = sequence, sequence = next;
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    progress.frame_done(took.count(), std::nullopt);
  }
  return finish(flags, sensor, flags.frames, outputs);
}

std::string scene_list() {
  std::string text = "Scenes:\n";
  for (const CatalogScene& scene : scene_catalog())
    text += fmt::format("  {:<11}{}\n", scene.name, scene.about);
  text += "Settings, after a question mark, joined by &:\n" + simulation_settings_help();
  return text + "Effects:\n  " + effect_names() + "\n";
}

Result<void> list_scenes(const SimulateFlags& flags) {
  if (!flags.output.empty() || !flags.truth.empty())
    return Error{ErrorCode::Invalid,
                 "--list prints the scenes and films none; leave it out, or --output and --truth"};
  write_result(scene_list());
  return {};
}

Result<void> simulate(const SimulateFlags& flags, const Settings& settings, Surroundings& around) {
  if (flags.scene.empty())
    return Error{ErrorCode::Invalid, "no scene given; 'hdrcam simulate --list' prints the scenes"};
  if (flags.output.empty() && flags.truth.empty() && !flags.explain)
    return Error{ErrorCode::Invalid, "nothing to do; give -o FILE, --truth FOLDER or --explain"};
  TRY(check_recording_name(around.storage, "--output", flags.output));
  const Simulation simulation = TRY(simulation_of(flags.scene));
  const Format format = TRY(format_of(flags));
  const std::vector<Exposure> cycle = TRY(parse_exposures(settings.schedule.shutter, settings.schedule.gain));
  TRY(check_distinct(cycle));
  const Timeline timeline(simulation, cycle);
  if (timeline.longest_s() * simulation.framerate_hz > 1)
    return Error{
        ErrorCode::BadExposure,
        fmt::format("an exposure of {:.1f} ms does not fit a frame at {} fps; lower --shutter or fps",
                    timeline.longest_s() * 1e3, simulation.framerate_hz)};
  TRY(admit_parts(settings, fmt::format("a scene of {}x{}", simulation.width, simulation.height),
                  simulator_bytes(simulation.width, simulation.height)));
  WorkerPool pool(thread_count(settings.fit));
  SimulatedSensor sensor(simulation, format.layout, format.bits, pool);
  if (flags.explain) {
    constexpr Duration kPatience = std::chrono::seconds(4);
    const EffectCosts costs =
        measure_costs(simulation, format.layout, format.bits, timeline.longest_s(), kPatience, pool);
    print_plan(sensor, costs, timeline.longest_s());
  }
  if (flags.output.empty() && flags.truth.empty()) return {};
  TRY(timeline.next_kept(0));  // before an output is opened
  if (around.stop) return stopped_before_any();
  TRY(flags.kept.check(around.storage, {}, outputs_of(flags)));
  Outputs outputs = TRY(open_outputs(around, flags, sensor, settings.record.codec));
  return film(around, flags, timeline, sensor, pool, outputs);
}

}  // namespace

void add_simulate(CLI::App& app, Verb& chosen) {
  auto flags = std::make_shared<SimulateFlags>();
  CLI::App* verb =
      app.add_subcommand("simulate", "film a simulated scene into a recording, with ground truth");
  verb->add_option("scene", flags->scene,
                   "name and settings, for instance walk?seed=3&size=320x240&objects=5");
  verb->add_option("-o,--output", flags->output, "the recording to write (.mkv)")->check(names_file);
  verb->add_option("--truth", flags->truth, "folder for a clip with ground truth, as compare reads it")
      ->check(names_file);
  verb->add_option("--frames", flags->frames, "frames to film")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000));
  verb->add_option("--format", flags->format, "pixel format: rgb or bayer")->capture_default_str();
  verb->add_option("--bits", flags->bits, "bits per sample, 8..16 [8 for rgb, 12 for bayer]");
  flags->kept.add_to(*verb);
  verb->add_flag("--list", flags->list, "print the scenes, their settings and the effects");
  verb->add_flag("--explain", flags->explain, "print which effects are on, why, and what they cost");
  flags->settings = std::make_unique<SettingsFlags>(
      *verb, std::vector<std::string>{"schedule.shutter", "schedule.gain", "fit.threads", "record.codec",
                                      "machine.memory_mib"});
  verb->callback([flags, &chosen] {
    chosen =
        flags->list ? [flags](Surroundings&) { return list_scenes(*flags); } : with_settings(flags, simulate);
  });
}

}  // namespace hdrcam
