// hdrcam calibrate delay --camera ID -o camera.toml: after how many frames the camera's controls act,
// measured from its pictures.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>

#include "capture/delay_calibration.h"
#include "firmware_host/commands/camera_run.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/run_files.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/settings/settings_toml.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/terminal.h"
#include "firmware_host/whole_percent.h"
#include "hal/core/counted.h"

namespace hdrcam {
namespace {

struct CalibrateFlags {
  std::string what, output;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

const std::vector<SettingGroup> kGroups{SettingGroup::Camera, SettingGroup::Schedule};

struct Pair {
  Exposure shorter, longer;
};

// Neighbouring times of the cycle, the middle ones first, because there the fewest pixels are clipped or
// dark.
std::vector<Pair> time_pairs(const ExposureSchedule& schedule, const CameraCapabilities& camera) {
  std::vector<Exposure> ladder;
  ladder.reserve(ExposureSchedule::kMaxSlots);
  for (const Exposure& exposure : schedule.cycle()) ladder.push_back({exposure.time, camera.gain_min});
  std::sort(ladder.begin(), ladder.end(),
            [](const Exposure& a, const Exposure& b) { return a.time < b.time; });
  std::vector<Pair> pairs;
  for (std::size_t i = 1; i < ladder.size(); ++i)
    if (ladder[i].time >= 2 * ladder[i - 1].time) pairs.push_back({ladder[i - 1], ladder[i]});
  std::rotate(pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(pairs.size() / 2), pairs.end());
  return pairs;
}

// Times at which the least gain and one of at least twice as much can be distinguished: those of the cycle,
// shortest first.
std::vector<Pair> gain_pairs(const ExposureSchedule& schedule, const CameraCapabilities& camera) {
  std::vector<Pair> pairs;
  const double most = std::min(camera.gain_max, 4 * camera.gain_min);
  if (most < 2 * camera.gain_min) return pairs;
  for (const Exposure& exposure : schedule.cycle())
    pairs.push_back({{exposure.time, camera.gain_min}, {exposure.time, most}});
  return pairs;
}

// The first pair of exposures that gives an answer.
Result<DelayEstimate> measure(Camera& camera, const CaptureOptions& options, const std::vector<Pair>& pairs,
                              const std::atomic<bool>& stop) {
  DelayEstimate estimate;
  for (const Pair& pair : pairs) {
    estimate = TRY(measure_delay(camera,
                                 {.shorter = pair.shorter,
                                  .longer = pair.longer,
                                  .mode = options.mode,
                                  .buffers = options.buffers,
                                  .unpack = options.unpack},
                                 stop));
    if (estimate.delay) break;
  }
  return estimate;
}

void print(const char* control, const DelayEstimate& estimate) {
  if (!estimate.delay)
    say("{}: unknown, {}\n", control, estimate.reason);
  else
    say("{}: acts {} after its request ({} % of {} agree)\n", control, counted(*estimate.delay, "frame"),
        whole_percent(static_cast<std::uint64_t>(estimate.agreed),
                      static_cast<std::uint64_t>(estimate.comparisons)),
        counted(estimate.comparisons, "comparison"));
}

Result<void> check_calibration(const std::string& what) {
  if (what.empty()) return Error{ErrorCode::Invalid, "no calibration named; give 'hdrcam calibrate delay'"};
  if (what != "delay")
    return Error{ErrorCode::Invalid,
                 fmt::format("there is no calibration '{}'; give 'calibrate delay'", what)};
  return {};
}

// Errors: Invalid where the cycle has no two exposures to compare; TooShort where their pictures do not tell.
Result<int> exposure_delay(Camera& camera, const CaptureOptions& options, const ExposureSchedule& schedule,
                           const std::string& shutter, const std::atomic<bool>& stop) {
  const std::vector<Pair> pairs = time_pairs(schedule, camera.capabilities());
  if (pairs.empty())
    return Error{
        ErrorCode::Invalid,
        fmt::format("no two exposures of --shutter {} are a stop or more apart, so their pictures cannot "
                    "be distinguished; give two that are, such as 1ms,4ms",
                    shutter)};
  const DelayEstimate estimate = TRY(measure(camera, options, pairs, stop));
  print("exposure", estimate);
  if (!estimate.delay)
    return Error{
        ErrorCode::TooShort,
        "the exposure delay could not be measured; point the camera at a static scene that is neither "
        "black nor clipped, in light that does not flicker, or give other times by --shutter"};
  return *estimate.delay;
}

// None where the gain cannot be set, or its pictures do not tell.
Result<std::optional<int>> gain_delay(Camera& camera, const CaptureOptions& options,
                                      const ExposureSchedule& schedule, const std::atomic<bool>& stop) {
  const std::vector<Pair> pairs = gain_pairs(schedule, camera.capabilities());
  if (pairs.empty()) {
    say("gain: cannot be set\n");
    return std::optional<int>();
  }
  const DelayEstimate estimate = TRY(measure(camera, options, pairs, stop));
  print("gain", estimate);
  return estimate.delay;
}

// Errors: those of the camera and of its settings; Unsupported where its exposure cannot be set.
Result<ControlDelays> measure_delays(Camera& camera, const Settings& settings,
                                     const std::atomic<bool>& stop) {
  const CameraCapabilities& capabilities = camera.capabilities();
  CaptureSetup setup = TRY(capture_setup(settings, capabilities));
  StreamMode& mode = setup.options.mode;
  mode = TRY(camera.configure(mode, setup.options.buffers));  // which knows of a sensor that it cannot reach
  if (!capabilities.sets_exposure)
    return Error{
        ErrorCode::Unsupported,
        fmt::format("the exposure of '{}' cannot be set; there is no delay to measure", capabilities.id)};
  setup.options.buffers = capabilities.buffers.value_or(setup.options.buffers);
  const auto schedule =
      TRY(ExposureSchedule::create(setup.cycle, capabilities, mode.frame_duration, setup.mains));
  const int exposure = TRY(exposure_delay(camera, setup.options, schedule, settings.schedule.shutter, stop));
  const std::optional<int> gain = TRY(gain_delay(camera, setup.options, schedule, stop));
  return ControlDelays{exposure, gain.value_or(exposure)};
}

Result<void> calibrate(const CalibrateFlags& flags, const Settings& settings, Surroundings& around) {
  TRY(check_calibration(flags.what));
  TRY(check_replayed(settings.camera, around.storage));
  TRY(flags.kept.check(around.storage, inputs_of(settings.camera),
                       {{"--output", flags.output, OutputKind::Settings}}));
  const auto camera = TRY(open_camera(settings.camera.id, around.storage));
  const ControlDelays delays = TRY(measure_delays(*camera, settings, around.stop));
  Settings measured = settings;
  if (measured.camera.id.empty()) measured.camera.id = camera->capabilities().id;
  measured.camera.control_delay = fmt::format("{},{}", delays.exposure, delays.gain);
  if (flags.output.empty()) {
    say("use it with --control-delay {}, or write a configuration with -o FILE\n",
        measured.camera.control_delay);
    return {};
  }
  const std::string toml = to_toml(measured, {SettingGroup::Camera});
  TRY(write_whole(around.storage, flags.output, std::as_bytes(std::span(toml))));
  say("use it with --config {}\n", shell_word(flags.output));
  return {};
}

}  // namespace

void add_calibrate(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<CalibrateFlags>();
  CommandLine verb = program.add_verb("calibrate", "measure a camera's control delay from its pictures");
  verb.add_option("what", flags->what,
                  "delay: control latency, in frames from a request to the picture that shows it")
      .type_name("delay");
  verb.add_option("-o,--output", flags->output, "configuration to write, for --config: camera.toml")
      .transform(named_at_start)
      .check(names_file);
  flags->kept.add_to(verb);
  flags->settings = std::make_unique<SettingsFlags>(
      verb, kGroups,
      // two exposures in turn are measured, of a camera whose exposure can be set
      std::vector<std::string>{"schedule.adapt", "camera.pace"});
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, calibrate); });
}

}  // namespace hdrcam
