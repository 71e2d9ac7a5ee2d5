#include "firmware_host/live/trigger_setup.h"

#include <algorithm>

#include "firmware_host/live/capture_setup.h"
#include "hal/clock.h"
#include "hal/core/counted.h"
#include "hal/real/sync_line_gpiod.h"
#include "hal/real/trigger_line_gpiod.h"
#include "hal/sim/simulated_trigger_line.h"

namespace hdrcam {
namespace {

constexpr std::string_view kSimulated = "sim";

Error refused(std::string sentence) { return {ErrorCode::Invalid, std::move(sentence)}; }

// A simulated camera has wires of its own, and hears of no others.
Result<void> check_place(const std::string& line, const char* flag, const std::string& camera) {
  const bool simulated = is_simulated(camera);
  if (line.empty() || simulated == (line == kSimulated)) return {};
  if (simulated)
    return refused(
        fmt::format("camera '{}' is simulated and does not see line '{}'; give {} sim", camera, line, flag));
  return refused(
      fmt::format("'{} sim' is the wire of a simulated camera, and the camera is '{}'; name a GPIO "
                  "line ('hdrcam list' shows them)",
                  flag, camera.empty() ? "the only one connected" : camera));
}

Result<void> check_trigger(const Settings::Sync& sync, const std::string& camera) {
  if (sync.trigger_line.empty() && sync.trigger == TriggerMode::Off) return {};
  if (sync.trigger_line.empty()) return refused("--trigger drives no line; name one with --trigger-line");
  if (sync.trigger == TriggerMode::Off)
    return refused(fmt::format("trigger line '{}' would not be driven; give --trigger fsync or pulse-width",
                               sync.trigger_line));
  if (is_replayed(camera))
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' cannot be triggered: its frames come as they were recorded; leave out "
                             "--trigger-line, or choose a camera",
                             camera)};
  TRY(check_place(sync.trigger_line, "--trigger-line", camera));
  if (!sync.line.empty() && sync.trigger_line != kSimulated && same_gpio_line(sync.line, sync.trigger_line))
    return refused(
        fmt::format("--trigger-line '{}' and --sync-line '{}' are the same line; a line either "
                    "drives the sensor or hears from it: choose another for one of them",
                    sync.trigger_line, sync.line));
  return {};
}

// Frames at the time of no pulse; in external trigger mode also those whose pictures contradict the width of
// the pulse at their time.
std::uint64_t off_pulses(const CaptureCounters& camera, TriggerMode mode) {
  const std::uint64_t found = camera.triggered + camera.pulses_forgotten;
  const std::uint64_t without = camera.captured - std::min(camera.captured, found);
  return mode == TriggerMode::PulseWidth ? without + camera.relabelled + camera.contradicted : without;
}

// Whether so many of a run's frames are more than an accident.
bool are_many(std::uint64_t frames, std::uint64_t of_all) {
  constexpr std::uint64_t kOneIn = 10;
  return kOneIn * frames > of_all;
}

}  // namespace

Result<void> check_lines(const Settings& settings) {
  const Settings::Sync& sync = settings.sync;
  TRY(check_trigger(sync, settings.camera.id));
  if (sync.line == kSimulated) TRY(check_place(sync.line, "--sync-line", settings.camera.id));
  return {};
}

Result<std::unique_ptr<CameraLines>> CameraLines::prepare(const Settings& settings) {
  const Settings::Sync& sync = settings.sync;
  TRY(check_lines(settings));
  std::unique_ptr<CameraLines> lines(new CameraLines(sync));
  if (sync.line == kSimulated) lines->strobe_wire_ = std::make_unique<SimulatedWire>(SimTime());
  if (sync.trigger_line == kSimulated)
    lines->trigger_wire_ = std::make_unique<SimulatedWire>(SimTime());
  else if (!sync.trigger_line.empty())
    lines->guard_ = TRY(guard_trigger_gpio({sync.trigger_line, sync.trigger_active_low}));
  return lines;
}

SimulatedWiring CameraLines::wiring() {
  return {strobe_wire_.get(), trigger_wire_.get(), trigger_wire_ ? sync_.trigger : TriggerMode::Off};
}

Result<TriggerOptions> CameraLines::options(Duration interval) const {
  TriggerOptions options{.mode = sync_.trigger, .interval = interval};
  options.width = TRY(parse_duration(sync_.trigger_width));
  options.gap = TRY(parse_duration(sync_.trigger_gap));
  options.tolerance = TRY(parse_duration(sync_.trigger_tolerance));
  return options;
}

Result<void> CameraLines::open(Duration interval) {
  if (strobe_wire_)
    strobe_ = std::make_unique<SimulatedSyncLine>(*strobe_wire_);
  else if (!sync_.line.empty())
    strobe_ = TRY(open_gpio_line({sync_.line, sync_.active_low}));
  if (sync_.trigger == TriggerMode::Off) return {};
  const TriggerOptions options = TRY(this->options(interval));
  std::unique_ptr<TriggerLine> line;
  if (trigger_wire_)
    line = std::make_unique<SimulatedTriggerLine>(*trigger_wire_);
  else
    line = TRY(open_trigger_gpio({sync_.trigger_line, sync_.trigger_active_low}));
  trigger_ = std::make_unique<Trigger>(std::move(line), options, posix_clock());
  thread_.emplace(*trigger_);
  return {};
}

std::string CameraLines::note() const {
  if (!thread_ || thread_->realtime()) return "";
  return fmt::format("trigger line '{}': {}", sync_.trigger_line, thread_->realtime().error().message);
}

std::string CameraLines::sentence(const CaptureCounters& camera) const {
  if (!trigger_) return "";
  const auto answers = strobe_ != nullptr ? TriggerAnswers::Heard : TriggerAnswers::NotHeard;
  std::string text = sentence_of(camera.trigger, sync_.trigger_line, trigger_->options(), answers);
  if (!realtime()) text += "; not scheduled in real time";
  if (const std::uint64_t odd = off_pulses(camera, sync_.trigger); are_many(odd, camera.captured))
    text += fmt::format(
        "; {} of {} do not fit the pulses: check --timestamp, and that the sensor waits for its trigger", odd,
        counted(camera.captured, "frame"));
  return text;
}

std::string CameraLines::strobe_sentence(const CaptureCounters& camera) const {
  constexpr std::uint64_t kSome = 8;  // more than a beginning costs
  if (!strobe_ || camera.captured == 0) return "";
  if (camera.strobe_misfits >= kSome && are_many(camera.strobe_misfits, camera.captured))
    return fmt::format(
        "strobe line '{}': the pulses of {} of {} are not as long as their exposures; check --strobe-delay, "
        "--timestamp and --sync-active-low, and that the camera does these exposures",
        sync_.line, camera.strobe_misfits, counted(camera.captured, "frame"));
  if (camera.strobed > 0) return "";
  return fmt::format(
      "strobe line '{}': no frame has a pulse; check its wiring, --sync-active-low and --strobe-delay",
      sync_.line);
}

}  // namespace hdrcam
