// hdrcam bench pareto CLIP..: what accuracy costs in time, on this machine. hdrcam bench kernels: how near
// the method's kernels are to what this processor can do.
#include <algorithm>
#include <memory>
#include <span>

#include "firmware_host/bench/cost_page.h"
#include "firmware_host/bench/kernel_rates.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/json_flag.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/run_files.h"
#include "firmware_host/commands/run_limits.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/terminal.h"
#include "hal/core/parse_number.h"

namespace hdrcam {
namespace {

// What `bench pareto` writes into its folder.
constexpr const char *kFigures = "pareto.json", *kCharts = "pareto.html", *kTable = "pareto.md";
constexpr const char* kPages[] = {kFigures, kCharts, kTable};

struct BenchFlags {
  CostWalk walk;
  std::vector<std::string> points;
  std::string output;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

// The points that were asked for by name, or all.
Result<std::vector<CostPoint>> chosen_points(std::vector<CostPoint> all,
                                             const std::vector<std::string>& names) {
  if (names.empty()) return all;
  std::vector<CostPoint> points;
  for (const std::string& wanted : names) {
    const auto found = std::ranges::find(all, wanted, &CostPoint::name);
    if (found == all.end()) {
      std::vector<std::string> known;
      known.reserve(all.size());
      for (const CostPoint& point : all) known.push_back(point.name);
      return Error{ErrorCode::Invalid,
                   fmt::format("there is no point '{}'; there are {}", wanted, fmt::join(known, ", "))};
    }
    points.push_back(*found);
  }
  return points;
}

// The command that makes the pages again.
std::string command_of(const BenchFlags& flags, const CostWalk& plan, const Settings& settings) {
  std::string command = "hdrcam bench pareto";
  for (const std::string& clip : plan.clips) command += " " + shell_word(clip);
  command += " --output " + shell_word(flags.output);
  for (const std::string& point : flags.points) command += " --point " + shell_word(point);
  if (plan.frames > 0) command += fmt::format(" --frames {}", plan.frames);
  if (plan.repeats > 1) command += fmt::format(" --repeats {}", plan.repeats);
  return command + flags.settings->as_flags(settings);
}

// Writes the pages into the folder and prints the table. Errors: those of the disk.
Result<void> show_costs(const MeasuredWalk& walk, const std::string& folder, Storage& storage) {
  const auto write = [&](const char* name, const std::string& text) {
    return write_whole(storage, folder + "/" + name, std::as_bytes(std::span(text)));
  };
  const std::string table = cost_table(walk.costs);
  TRY(write(kTable, table));
  TRY(write(kFigures, cost_json(walk)));
  TRY(write(kCharts, cost_page(walk)));
  say("{}{}/{}: the charts; {} and {}: the figures\n", table, folder, kCharts, kFigures, kTable);
  return {};
}

// Before any run: earlier pages stay without --force, and the folder of the frames must not be there yet.
Result<void> check_pages(const BenchFlags& flags, const std::string& scratch, Storage& storage) {
  std::vector<NamedInput> inputs;
  for (const std::string& clip : flags.walk.clips) {
    TRY(check_clip_folder(storage, clip));
    for (NamedInput& file : files_of_clip(clip)) inputs.push_back(std::move(file));
  }
  std::vector<NamedOutput> pages;
  for (const char* const name : kPages)
    pages.push_back({"--output", flags.output + "/" + name, OutputKind::Document});
  TRY(flags.kept.check(storage, inputs, pages));
  if (TRY(storage.look_at(scratch)).kind == FileKind::Missing) return {};
  return Error{ErrorCode::Exists, fmt::format("'{}' is in the way of the frames to be scored; name another "
                                              "folder with --output, or remove it",
                                              scratch)};
}

// The runs have outputs of their own: those of a file of settings are for other verbs.
Result<void> bench_pareto(const BenchFlags& flags, const Settings& asked, Surroundings& around) {
  Settings settings = asked;
  settings.machine.trace.clear();
  CostWalk plan = flags.walk;
  plan.points = TRY(chosen_points(cost_points(settings.fit), flags.points));
  const std::string scratch = flags.output + "/frames";
  TRY(check_pages(flags, scratch, around.storage));
  std::vector<PointCost> costs;
  const Result<void> walked = walk(plan, settings, scratch, around.storage, around.stop, costs);
  const bool interrupted = !walked && walked.error().code == ErrorCode::Interrupted;
  if (interrupted && costs.empty())
    return Error{ErrorCode::Interrupted, "stopped before a point was measured; nothing was written"};
  if (!walked && costs.empty()) return walked.error();

  TRY(show_costs(
      {.costs = costs, .command = command_of(flags, plan, settings), .threads = thread_count(settings.fit)},
      flags.output, around.storage));
  if (interrupted)
    return Error{ErrorCode::Interrupted, fmt::format("stopped after {} of {} points; the pages hold these",
                                                     costs.size(), plan.points.size() * plan.clips.size())};
  return walked;
}

struct KernelBenchFlags {
  int width = 640, height = 480;
  double seconds = 0.2;
  JsonFlag json;
  KeptWork kept;
};

Result<void> bench_kernels(Surroundings& around, const KernelBenchFlags& flags) {
  TRY(flags.kept.check(around.storage, {}, {flags.json.output()}));
  const KernelRates rates =
      TRY(measure_kernels(kernel_tasks(flags.height, flags.width), flags.seconds, around.stop));
  if (!flags.json.stands_for_table()) say("{}", rates_table(rates));
  return flags.json.write(around.storage, rates_json(rates, flags.height, flags.width));
}

void add_bench_kernels(CommandLine bench, Verb& chosen) {
  auto flags = std::make_shared<KernelBenchFlags>();
  CommandLine verb = bench.add_verb(
      "kernels", "the rate of each kernel on one thread, beside what this processor can do, in one run");
  verb.add_option("--width", flags->width, "width of the pictures, px").in_range(64, 8192).show_default();
  verb.add_option("--height", flags->height, "height of the pictures, px").in_range(64, 8192).show_default();
  verb.add_option("--seconds", flags->seconds, "time for each kernel, s; the fastest fifth counts")
      .check([](const std::string& text) {
        const auto seconds = parse_number<double>(text);
        const bool sound = seconds && *seconds >= 0.001 && *seconds <= 60;
        return sound ? std::string() : fmt::format("takes seconds, 0.001 to 60, not '{}'", text);
      })
      .show_default();
  flags->json.add_to(verb, "the figures");
  flags->kept.add_without_force(verb);
  verb.on_chosen(
      [flags, &chosen] { chosen = [flags](Surroundings& around) { return bench_kernels(around, *flags); }; });
}

}  // namespace

void add_bench(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<BenchFlags>();
  CommandLine bench = program.add_verb(
      "bench", "measure what accuracy costs in time, and how fast each kernel is, on this machine");
  bench.require_verb();
  add_bench_kernels(bench, chosen);
  CommandLine verb = bench.add_verb(
      "pareto", "walk the knobs over clips with ground truth: time, quality and flicker of each point");
  verb.add_option("CLIP", flags->walk.clips, "folders with clip.json and gt/, as compare reads them")
      .required()
      .check(names_file);
  verb.add_option("-o,--output", flags->output, "folder for pareto.html, pareto.json and pareto.md")
      .required()
      .transform(named_at_start)
      .check(names_folder);
  verb.add_option("--point", flags->points,
                  "only this point of the walk, such as fast or 'look-ahead 0'; may be repeated [all]");
  verb.add_option("--frames", flags->walk.frames, "frames to take of each clip [all]").check(counts_frames());
  verb.add_option("--repeats", flags->walk.repeats, "runs of each point; the fastest counts")
      .in_range(1, 100)
      .show_default();
  flags->kept.add_to(verb);
  flags->settings = std::make_unique<SettingsFlags>(
      verb, std::vector<SettingGroup>{SettingGroup::Fit, SettingGroup::Knobs, SettingGroup::Machine},
      std::vector<std::string>{"machine.trace"});  // of one run, and these are many
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, bench_pareto); });
}

}  // namespace hdrcam
