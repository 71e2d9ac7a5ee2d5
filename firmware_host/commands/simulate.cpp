// hdrcam simulate SCENE -o walk.mkv: a recording of a simulated scene, and with --truth its ground truth as a
// clip that `hdrcam compare` scores against.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "capture/exposure_schedule.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/recording_name.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/cut_recording.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/run/progress.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/simulation/clip_timeline.h"
#include "firmware_host/simulation/truth_clip.h"
#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/terminal.h"
#include "hal/core/counted.h"
#include "hal/core/stopwatch.h"
#include "hal/recording/recording.h"
#include "hal/sim/effect_costs.h"

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
    return Error{ErrorCode::Invalid, fmt::format("--format takes rgb or bayer, not '{}'", flags.format)};
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

// All files that the run writes, those of the truth first.
std::vector<NamedOutput> outputs_of(const SimulateFlags& flags) {
  std::vector<NamedOutput> outputs;
  if (!flags.truth.empty()) outputs = TruthClip::outputs("--truth", flags.truth);
  outputs.push_back({"--output", flags.output, OutputKind::Recording});
  return outputs;
}

// The outputs of a run; each exists if it was requested.
struct Outputs {
  std::unique_ptr<RecordingWriter> recording;
  std::unique_ptr<TruthClip> clip;
  std::vector<EarlierFrames> earlier;  // where those of the clip go
};

std::vector<EarlierFrames> earlier_frames_of(const SimulateFlags& flags, Storage& storage) {
  std::vector<EarlierFrames> earlier;
  for (const NamedOutput& output : outputs_of(flags))
    if (output.kind == OutputKind::Frames) earlier.emplace_back(storage, output.path);
  return earlier;
}

Result<Outputs> open_outputs(Surroundings& around, const SimulateFlags& flags, const SimulatedSensor& sensor,
                             RecordingCodec codec, WorkerPool& pool) {
  Outputs outputs{.recording = {}, .clip = {}, .earlier = earlier_frames_of(flags, around.storage)};
  if (!flags.truth.empty())
    outputs.clip = TRY(TruthClip::create(around.storage, flags.truth, sensor, flags.scene, pool));
  // last, so that a refused run never empties an earlier recording
  if (!flags.output.empty())
    outputs.recording =
        TRY(create_recording(around.storage, flags.output, sensor.facts(), Creation::Replace, codec));
  return outputs;
}

// The outcome of writing after so many whole frames. Where it failed the recording has no end.
Result<void> or_cut(Result<void> wrote, const SimulateFlags& flags, int frames) {
  if (wrote || flags.output.empty()) return wrote;
  return cut_recording(wrote.error(), flags.output, static_cast<std::uint64_t>(frames));
}

// Completes the outputs of a run with so many frames; without any they stay as they are.
Result<void> finish(const SimulateFlags& flags, const SimulatedSensor& sensor, int frames, Outputs& outputs) {
  if (frames == 0) return {};
  if (outputs.recording) {
    TRY(or_cut(outputs.recording->finish(), flags, frames));
    say("{}\n", describe_recording(flags.output, sensor.facts(), static_cast<std::uint64_t>(frames)));
  }
  if (outputs.clip) {
    TRY(outputs.clip->finish());
    for (const EarlierFrames& earlier : outputs.earlier)
      if (const std::string warning = earlier.warning(); !warning.empty()) remark("warning: {}\n", warning);
    say("{}: a clip of {} with ground truth\n", flags.truth, counted(frames, "image"));
  }
  return {};
}

Error stopped_before_any() { return {ErrorCode::Interrupted, "stopped before the first frame"}; }

Result<void> film(Surroundings& around, const SimulateFlags& flags, const ClipTimeline& timeline,
                  SimulatedSensor& sensor, Outputs& outputs) {
  Progress progress(stderr, flags.frames);
  RawFrame frame;
  std::uint64_t sequence = TRY(timeline.next_kept(0));
  bool after_drop = false;
  for (int i = 0; i < flags.frames; ++i) {
    if (around.stop) {
      TRY(finish(flags, sensor, i, outputs));
      return i == 0 ? stopped_before_any()
                    : Error{ErrorCode::Interrupted,
                            fmt::format("stopped after {} of {} frames; they are complete", i, flags.frames)};
    }
    Stopwatch watch;
    sensor.expose(timeline.shot(sequence), frame.codes);
    frame.facts = timeline.facts(sequence, after_drop, sensor.facts().bits);
    const std::uint64_t next = TRY(timeline.next_kept(sequence + 1));
    if (outputs.recording) TRY(or_cut(outputs.recording->append(frame), flags, i));
    if (outputs.clip)
      TRY(or_cut(outputs.clip->append(frame, timeline.centre_s(sequence), timeline.centre_s(next)), flags,
                 i + 1));
    after_drop = next != sequence + 1, sequence = next;
    progress.frame_done(watch.lap_ms(), std::nullopt);
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
                 "--list prints the scenes and films none; leave out --list, or --output and --truth"};
  write_result(scene_list());
  return {};
}

Result<void> simulate(const SimulateFlags& flags, const Settings& settings, Surroundings& around) {
  if (flags.list) return list_scenes(flags);
  if (flags.scene.empty())
    return Error{ErrorCode::Invalid, "no scene given; 'hdrcam simulate --list' prints the scenes"};
  if (flags.output.empty() && flags.truth.empty() && !flags.explain)
    return Error{ErrorCode::Invalid, "nothing to do; give -o FILE, --truth FOLDER or --explain"};
  TRY(check_recording_name(around.storage, "--output", flags.output));
  const Simulation simulation = TRY(simulation_of(flags.scene));
  const Format format = TRY(format_of(flags));
  const std::vector<Exposure> cycle = TRY(parse_exposures(settings.schedule.shutter, settings.schedule.gain));
  TRY(check_slots(cycle));
  TRY(check_distinct(cycle));
  const ClipTimeline timeline = TRY(ClipTimeline::create(simulation, cycle));
  TRY(admit_parts(settings, fmt::format("a scene of {}x{}", simulation.width, simulation.height),
                  simulator_bytes(simulation.width, simulation.height)));
  WorkerPool pool(thread_count(settings.fit));
  SimulatedSensor sensor(simulation, format.layout, format.bits, pool);
  if (flags.explain) {
    constexpr Duration kPatience = std::chrono::seconds(4);
    const EffectCosts costs =
        measure_costs(simulation, format.layout, format.bits, timeline.longest_exposure_s(), kPatience, pool);
    print_plan(sensor, costs, timeline.longest_exposure_s());
  }
  if (flags.output.empty() && flags.truth.empty()) return {};
  TRY(timeline.next_kept(0));  // before an output is opened
  if (around.stop) return stopped_before_any();
  TRY(flags.kept.check(around.storage, {}, outputs_of(flags)));
  Outputs outputs = TRY(open_outputs(around, flags, sensor, settings.record.codec, pool));
  return film(around, flags, timeline, sensor, outputs);
}

}  // namespace

void add_simulate(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<SimulateFlags>();
  CommandLine verb =
      program.add_verb("simulate", "film a simulated scene into a recording, with ground truth");
  verb.add_option("scene", flags->scene,
                  "name and settings, for instance walk?seed=3&size=320x240&objects=5");
  verb.add_option("-o,--output", flags->output, "the recording to write (.mkv)")
      .transform(named_at_start)
      .check(names_file);
  verb.add_option("--truth", flags->truth, "folder for a clip with ground truth, as compare reads it")
      .transform(named_at_start)
      .check(names_folder);
  verb.add_option("--frames", flags->frames, "frames to film").show_default().in_range(1, 1'000'000);
  verb.add_option("--format", flags->format, "pixel format: rgb or bayer")
      .show_default()
      .type_name("rgb|bayer");
  verb.add_option("--bits", flags->bits, "bits per sample [8 for rgb, 12 for bayer]").in_range(8, 16);
  flags->kept.add_to(verb);
  verb.add_switch("--list", flags->list, "print the scenes, their settings and the effects");
  verb.add_switch("--explain", flags->explain, "print which effects are on, why, and what they cost");
  flags->settings = std::make_unique<SettingsFlags>(
      verb, std::vector<std::string>{"schedule.shutter", "schedule.gain", "fit.threads", "record.codec",
                                     "machine.memory_mib"});
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, simulate); });
}

}  // namespace hdrcam
