#include "firmware_host/live/live_report.h"

#include <fmt/ranges.h>

#include "firmware_host/command_line.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/whole_percent.h"

namespace hdrcam {
namespace {

// The output for which the fit waited longer than it worked; null where it did not. One that leaves frames
// out does not keep the fit waiting.
const SinkTimes* output_waited_for(const RunRecord& record) {
  const double method_ms = method_summary(record).mean_ms;
  if (mean_ms_per_frame(record) <= 2 * method_ms) return nullptr;
  const SinkTimes* slowest = nullptr;
  for (const SinkTimes& sink : record.sinks)
    if (sink.left_out == 0 && (slowest == nullptr || sink.total_ms > slowest->total_ms)) slowest = &sink;
  return slowest;
}

// None of a run without a trigger.
std::vector<NamedValue> trigger_values(const TriggerCounters& trigger) {
  if (trigger.pulses == 0) return {};
  std::vector<NamedValue> list;
  const auto count = [&](const char* name, std::uint64_t value) {
    list.push_back({name, static_cast<double>(value)});
  };
  count("trigger.pulses", trigger.pulses);
  count("trigger.late", trigger.late);
  count("trigger.left_out", trigger.left_out);
  count("trigger.answered", trigger.answered);
  count("trigger.unanswered", trigger.unanswered);
  count("trigger.unasked", trigger.spurious);  // the key of earlier versions
  list.push_back({"trigger.edge_us_mean", to_seconds(trigger.edge_mean) * 1e6});
  list.push_back({"trigger.edge_us_p99", to_seconds(trigger.edge_p99) * 1e6});
  list.push_back({"trigger.edge_us_most", to_seconds(trigger.edge_most) * 1e6});
  return list;
}

}  // namespace

std::string live_line(double elapsed_s, const LiveCounters& counters, LiveWork work) {
  const CaptureCounters& camera = counters.camera;
  std::string line = fmt::format("{:.1f} s  captured {}", elapsed_s, counters.captured());
  if (work == LiveWork::Fit)
    line += fmt::format("  emitted {}  dropped {}  latency {:.0f} ms", counters.emitted, counters.dropped(),
                        to_seconds(counters.latency) * 1e3);
  else
    line += fmt::format("  recorded {}  dropped {}", counters.recorded, counters.not_recorded());
  if (camera.lost_by_camera > 0) line += fmt::format("  lost {}", camera.lost_by_camera);
  return line + fmt::format("  exposure proved {} %", whole_percent(camera.proved, camera.emitted));
}

void LiveStatus::update() {
  if (!line_.due()) return;
  elapsed_s_ += watch_.lap_ms() * 1e-3;
  line_.show(live_line(elapsed_s_, session_.counters(), work_));
}

std::string sentence_of(const LiveCounters& counters, LiveWork work) {
  const bool fits = work == LiveWork::Fit;
  const std::pair<std::uint64_t, const char*> reasons[] = {
      {fits ? 0 : counters.unwritten, "not written, the recording failed"},
      {counters.shed, "shed, the fit or an output was busy"},
      {counters.left_out, "left out to hold the deadline"},
      {counters.unproved, "exposure not proved"},
      {counters.pool_full, "no room, the disk was busy"},
      {counters.camera.damaged, "damaged"},
      {counters.camera.undecodable, "not decodable"},
      {counters.unfinished, "not finished"},
  };
  std::vector<std::string> dropped;
  for (const auto& [count, reason] : reasons)
    if (count > 0) dropped.push_back(fmt::format("{} {}", count, reason));
  const std::string why = dropped.empty() ? "" : fmt::format(" ({})", fmt::join(dropped, ", "));
  std::string text = fits ? fmt::format("captured {} = emitted {} + dropped {}{}", counters.captured(),
                                        counters.emitted, counters.dropped(), why)
                          : fmt::format("captured {} = recorded {} + dropped {}{}", counters.captured(),
                                        counters.recorded, counters.not_recorded(), why);
  if (counters.camera.lost_by_camera > 0)
    text += fmt::format("; {} more never came from the camera", counters.camera.lost_by_camera);
  return text;
}

std::string advice_to_keep_up(const LiveCounters& counters, const Settings& settings,
                              const RunRecord& record) {
  if (counters.shed + counters.left_out == 0) return "";
  const SinkTimes* output = output_waited_for(record);
  const std::string slow = output == nullptr
                               ? "the fit"
                               : fmt::format("the output '{}' ({:.0f} ms a frame; the fit {:.0f} ms)",
                                             settings.output.path(output->name), output->mean_ms(),
                                             method_summary(record).mean_ms);
  const bool holds_stated_deadline = counters.left_out > 0 && !settings.fit.deadline.empty();
  if (is_replayed(settings.camera.id))
    return fmt::format(
        "{} did not keep up with the recording; leave out --pace realtime{}, and every frame is worked on",
        slow, holds_stated_deadline ? " and --deadline" : "");
  const std::string& recording = settings.record.file;
  const std::uint64_t elsewhere = counters.in_takes + counters.not_requested;
  const bool whole = counters.not_recorded() + elsewhere == 0 && counters.recorded > 0;
  const std::string later =
      recording.empty() ? "; --record walk.mkv keeps all frames for a replay"
      : whole           ? fmt::format("; all frames are recorded: hdrcam replay {}", shell_word(recording))
                        : "";
  if (output != nullptr)
    return fmt::format(
        "{} did not keep up with the camera; give it a faster disk or reader, leave it out, or give a "
        "smaller --width and --height{}",
        slow, later);
  return fmt::format("the fit did not keep up with the camera; give {}a smaller --width and --height{}{}",
                     settings.fit.preset == Preset::Realtime ? "" : "--preset realtime, ",
                     counters.left_out > 0 ? ", or --deadline off, where frames may be late" : "", later);
}

std::string advice_on_light(const LiveCounters& counters, const Settings& settings) {
  constexpr std::uint64_t kFewestFrames = 30, kFewInOne = 10;  // one in so many
  const CaptureCounters& camera = counters.camera;
  if (is_replayed(settings.camera.id) || settings.schedule.mains != Mains::Off) return "";
  if (camera.emitted < kFewestFrames || kFewInOne * camera.contradicted <= camera.emitted) return "";
  return fmt::format(
      "the pictures contradict the exposures of {} of {} frames; where lamps light the scene, their flicker "
      "does that: give --mains 50 or 60, and exposures of 10 ms or more",
      camera.contradicted, camera.emitted);
}

std::vector<NamedValue> named(const LiveCounters& counters) {
  const CaptureCounters& camera = counters.camera;
  const std::pair<const char*, std::uint64_t> values[] = {
      {"captured", counters.captured()},
      {"emitted", counters.emitted},
      {"recorded", counters.recorded},
      {"dropped", counters.dropped()},
      {"dropped.shed", counters.shed},
      {"dropped.deadline", counters.left_out},
      {"dropped.unproved", counters.unproved},
      {"dropped.no_room", counters.pool_full},
      {"dropped.damaged", camera.damaged},
      {"dropped.undecodable", camera.undecodable},
      {"dropped.unfinished", counters.unfinished},
      {"not_recorded", counters.not_recorded()},
      {"camera.lost", camera.lost_by_camera},
      {"camera.proved", camera.proved},
      {"camera.plausible", camera.plausible},
      {"camera.estimated", camera.estimated},
      {"camera.contradicted", camera.contradicted},
      {"camera.unknown", camera.unknown},
      {"camera.relabelled", camera.relabelled},
      {"camera.unreported", camera.unreported},
      {"camera.repeated_cookies", camera.repeated_cookies},
      {"camera.strobed", camera.strobed},
      {"camera.strobe_misfits", camera.strobe_misfits},
      {"camera.triggered", camera.triggered},
      {"camera.pulses_forgotten", camera.pulses_forgotten},
      {"camera.controls_late", camera.controls_late},
      {"camera.requests_late", camera.requests_late},
      {"camera.relocks", camera.relocks},
      {"camera.cycle_changes", camera.cycle_changes},
  };
  std::vector<NamedValue> list = trigger_values(camera.trigger);
  for (const auto& [name, value] : values) list.push_back({name, static_cast<double>(value)});
  list.push_back({"first_frame_ms", to_seconds(counters.first_frame) * 1e3});
  list.push_back({"longest_latency_ms", to_seconds(counters.longest_latency) * 1e3});
  return list;
}

}  // namespace hdrcam
