#include "firmware_host/commands/recording_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "firmware_host/commands/summary_table.h"
#include "firmware_host/printable.h"
#include "firmware_host/signed_text.h"
#include "hal/core/counted.h"
#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNotJudged = "not judged";

std::string counts_text(const std::map<std::string, std::uint64_t>& counts) {
  std::string text;
  for (const auto& [what, count] : counts)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  return text.empty() ? "none" : text;
}

double range_ev(const RecordingSummary& summary) {
  return summary.shortest_exposure_s > 0 ? std::log2(summary.longest_exposure_s / summary.shortest_exposure_s)
                                         : 0;
}

// The slots in EV about the geometric mean of the cycle, the reference exposure.
std::vector<double> slots_ev(const ExposureCycle& cycle) {
  std::vector<double> slots;
  double mean = 0;
  for (const double exposure : cycle.exposures) slots.push_back(std::log2(exposure));
  for (const double slot : slots) mean += slot / static_cast<double>(slots.size());
  for (double& slot : slots) slot = std::round((slot - mean) * 1e6) * 1e-6 + 0.0;  // no -0
  return slots;
}

double reference_s(const ExposureCycle& cycle) {
  double sum = 0;
  for (const double exposure : cycle.exposures) sum += std::log2(exposure);
  return std::exp2(sum / static_cast<double>(cycle.exposures.size()));
}

void count(RecordingSummary& summary, const FrameFacts& facts, const FrameFacts* before) {
  ++summary.frames;
  if (before != nullptr && facts.sequence > before->sequence + 1) {
    ++summary.gaps;
    summary.dropped += facts.sequence - before->sequence - 1;
  }
  ++summary.verdicts[facts.verdict ? name(*facts.verdict) : kNotJudged];
  ++summary.sources[name(facts.exposure_source)];
  if (!summary.black_level) summary.black_level = facts.black_level;
  summary.unproved += (facts.flags & kFrameExposureUnproved) != 0;
  summary.damaged += (facts.flags & kFrameDamaged) != 0;
  summary.with_pose += facts.T_world_camera.has_value();
  const double exposure = facts.exposure();
  if (!(exposure > 0) || !std::isfinite(exposure)) return;
  summary.amplified |= facts.gain() != 1;
  summary.longest_exposure_s = std::max(summary.longest_exposure_s, exposure);
  summary.shortest_exposure_s =
      summary.shortest_exposure_s > 0 ? std::min(summary.shortest_exposure_s, exposure) : exposure;
}

// Exposures that were estimated from the pictures are no times.
bool is_relative(const RecordingSummary& summary) {
  return summary.sources.contains(name(ExposureSource::Estimated));
}

const char* exposure_unit(const RecordingSummary& summary) { return summary.amplified ? "s x gain" : "s"; }

std::string schedule_text(const RecordingSummary& summary) {
  const ExposureCycle& cycle = summary.cycle;
  if (cycle.period == 0) return "none found";
  std::string text;
  for (const double slot : slots_ev(cycle)) text += (text.empty() ? "" : " / ") + signed_text(slot, 2);
  return fmt::format("{}: {} EV{}", counted(cycle.period, "slot"), text,
                     is_relative(summary)
                         ? ""
                         : fmt::format(" about {:.6g} {}", reference_s(cycle), exposure_unit(summary)));
}

std::string exposures_text(const RecordingSummary& summary) {
  if (!(summary.longest_exposure_s > 0)) return "unknown";
  if (is_relative(summary))
    return fmt::format("estimated from the pictures, relative, {:.2f} EV", range_ev(summary));
  return fmt::format("{:.6g} .. {:.6g} {}, {:.2f} EV", summary.shortest_exposure_s,
                     summary.longest_exposure_s, exposure_unit(summary), range_ev(summary));
}

}  // namespace

Result<RecordingSummary> summarize(Storage& storage, const std::string& path, const std::atomic<bool>& stop) {
  auto reader = TRY(open_recording(storage, path, Damage::IsSkipped));
  RecordingSummary summary;
  summary.camera = reader->camera();
  summary.codec = reader->codec();
  const auto file = TRY(storage.open(path));
  summary.bytes = TRY(file->size());
  ExposureCycleSearch schedule;
  std::optional<FrameFacts> before;
  std::optional<Instant> start;
  for (;;) {
    if (stop)
      return Error{ErrorCode::Interrupted,
                   fmt::format("stopped after {} of '{}'; what comes behind is not known",
                               counted(summary.frames, "frame"), path)};
    auto facts = reader->next_facts();
    if (!facts) summary.end = facts.error();
    if (!facts || !facts.value()) break;
    count(summary, **facts, before ? &*before : nullptr);
    schedule.add(**facts);
    before = **facts;
    if (!start) start = before->timestamp;
  }
  summary.left_out = reader->left_out();
  summary.behind = told_of_behind(*reader);
  summary.cycle = schedule.cycle();
  if (start) summary.duration = before->timestamp - *start + from_seconds(1 / summary.camera.framerate_hz);
  return summary;
}

std::string as_table(const RecordingSummary& summary, const std::string& path) {
  const CameraFacts& camera = summary.camera;
  SummaryTable table(path);
  table.row("camera", shown_name(camera.name));
  table.row("picture",
            fmt::format("{}x{}, {} bits, {}", camera.width, camera.height, camera.bits, name(camera.layout)));
  table.row("frame rate", fmt::format("{:.6g} Hz", camera.framerate_hz));
  if (const auto& lens = camera.intrinsics) table.row("lens", describe(*lens));
  table.row("response", camera.linear ? "linear" : camera.response.empty() ? "unknown" : "known");
  if (camera.white_balance)
    table.row("white", fmt::format("gains {:.4g}", fmt::join(*camera.white_balance, ", ")));
  if (camera.turned_upright) table.row("turned", "upright, when it was imported");
  table.row("schedule", schedule_text(summary));
  table.row("exposures", exposures_text(summary));
  table.row("verdict", counts_text(summary.verdicts));
  table.row("source", counts_text(summary.sources));
  if (summary.black_level)
    table.row("black level", fmt::format("{:.2f} codes of 255", (*summary.black_level)[1]));
  table.row("frames", fmt::format("{} in {:.3f} s", summary.frames, to_seconds(summary.duration)));
  table.row("dropped", summary.dropped == 0
                           ? "none"
                           : fmt::format("{} in {}", summary.dropped, counted(summary.gaps, "gap")));
  if (summary.unproved > 0)
    table.row("unproved", fmt::format("{} of uncertain exposure", counted(summary.unproved, "frame")));
  if (summary.damaged > 0) table.row("damaged", counted(summary.damaged, "frame"));
  table.row("poses", summary.with_pose == 0
                         ? "none"
                         : fmt::format("{} of {}", summary.with_pose, counted(summary.frames, "frame")));
  table.row("size", fmt::format("{}, {}", describe_size(summary.bytes), name(summary.codec)));
  const std::string damage = summary.left_out.sentence();
  if (!damage.empty()) table.row("unreadable", damage);
  table.row("complete", summary.end      ? "no: " + printable(summary.end->message)
                        : damage.empty() ? "yes"
                                         : "no");
  return table.text();
}

std::string as_json(const RecordingSummary& summary, const std::string& path) {
  const CameraFacts& camera = summary.camera;
  Json json = {{"recording", path},
               {"name", camera.name},
               {"width", camera.width},
               {"height", camera.height},
               {"bits", camera.bits},
               {"layout", name(camera.layout)},
               {"linear", camera.linear},
               {"framerate_hz", camera.framerate_hz},
               {"response_known", !camera.response.empty()},
               {"slots_ev", slots_ev(summary.cycle)},
               {"shortest_exposure_s", summary.shortest_exposure_s},
               {"longest_exposure_s", summary.longest_exposure_s},
               {"exposure_range_ev", range_ev(summary)},
               {"frames", summary.frames},
               {"duration_s", to_seconds(summary.duration)},
               {"dropped", summary.dropped},
               {"gaps", summary.gaps},
               {"unproved", summary.unproved},
               {"verdicts", summary.verdicts},
               {"exposure_sources", summary.sources},
               {"damaged", summary.damaged},
               {"with_pose", summary.with_pose},
               {"codec", name(summary.codec)},
               {"bytes", summary.bytes},
               {"unreadable", summary.left_out.count},
               {"unreadable_places", summary.left_out.places},
               {"complete", !summary.end && summary.left_out.sentence().empty()}};
  if (camera.intrinsics) json["intrinsics"] = json_of(*camera.intrinsics);
  if (camera.white_balance) json["white_balance"] = *camera.white_balance;
  if (camera.turned_upright) json["turned_upright"] = true;
  if (summary.black_level) json["black_level"] = (*summary.black_level)[1];
  if (summary.end) json["ended_by"] = summary.end->message;
  return json_text(json, 2) + "\n";
}

}  // namespace hdrcam
