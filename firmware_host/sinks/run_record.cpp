#include "firmware_host/sinks/run_record.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include <nlohmann/json.hpp>

#include "firmware_host/sinks/provenance_palette.h"
#include "firmware_host/version.h"
#include "hal/core/cpu.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

StageSummary summary_of(std::string name, std::vector<double> times_ms) {
  StageSummary summary{.name = std::move(name), .frames = static_cast<int>(times_ms.size())};
  if (times_ms.empty()) return summary;
  std::sort(times_ms.begin(), times_ms.end());
  const auto count = static_cast<double>(times_ms.size());
  summary.mean_ms = std::accumulate(times_ms.begin(), times_ms.end(), 0.0) / count;
  summary.p95_ms = times_ms[static_cast<std::size_t>(std::ceil(0.95 * count)) - 1];  // nearest rank
  summary.max_ms = times_ms.back();
  return summary;
}

template <class Values>
Json object_of(const Values& values) {
  Json object = Json::object();
  for (const NamedValue& entry : values) object[std::string(entry.name)] = entry.value;
  return object;
}

template <class Shares>
Json provenance_of(const Shares& shares) {
  Json object = Json::object();
  for (std::size_t i = 0; i < kProvenances; ++i) object[kProvenanceLooks[i].key] = shares[i];
  return object;
}

Json json_of(const FrameRecord& frame) {
  Json json{{"sequence", frame.sequence},        {"time_s", frame.time_s},
            {"exposure", frame.exposure},        {"total_ms", frame.total_ms},
            {"fit_steps", frame.fit_steps},      {"stages_ms", object_of(frame.stages_ms)},
            {"losses", object_of(frame.losses)}, {"provenance", provenance_of(frame.provenance_share)}};
  if (frame.latency_ms > 0) json["latency_ms"] = frame.latency_ms;
  if (!frame.note.empty()) json["note"] = frame.note;
  return json;
}

}  // namespace

std::vector<StageSummary> stage_summaries(const RunRecord& record) {
  std::vector<std::string> names;
  std::vector<std::vector<double>> times_ms;
  std::vector<double> totals_ms;
  for (const FrameRecord& frame : record.frames) {
    totals_ms.push_back(frame.total_ms);
    for (const NamedValue& stage : frame.stages_ms) {
      const auto known = std::find(names.begin(), names.end(), stage.name);
      const auto i = static_cast<std::size_t>(known - names.begin());
      if (known == names.end()) names.emplace_back(stage.name), times_ms.emplace_back();
      times_ms[i].push_back(stage.value);
    }
  }
  std::vector<StageSummary> summaries;
  for (std::size_t i = 0; i < names.size(); ++i)
    summaries.push_back(summary_of(names[i], std::move(times_ms[i])));
  summaries.push_back(summary_of("total", std::move(totals_ms)));
  return summaries;
}

double mean_ms_per_frame(const RunRecord& record) {
  double sum_ms = 0;
  for (const FrameRecord& frame : record.frames) sum_ms += frame.total_ms;
  return record.frames.empty() ? 0 : sum_ms / static_cast<double>(record.frames.size());
}

std::array<double, kProvenances> mean_provenance(const RunRecord& record) {
  std::array<double, kProvenances> shares{};
  for (const FrameRecord& frame : record.frames)
    for (std::size_t i = 0; i < kProvenances; ++i)
      shares[i] += frame.provenance_share[i] / static_cast<double>(record.frames.size());
  return shares;
}

double peak_memory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts in KiB
}

std::string to_json(const RunRecord& record) {
  Json json{{"hdrcam", kVersion},
            {"title", record.title},
            {"command", record.command},
            {"preset", record.preset},
            {"seed", record.seed},
            {"threads", record.threads},
            {"cpu", cpu_model()},
            {"instruction_set", name(instruction_set())},
            {"camera", record.camera},
            {"width", record.width},
            {"height", record.height},
            {"framerate_hz", record.framerate_hz},
            {"deadline_ms", record.deadline_ms},
            {"captured", record.captured},
            {"emitted", record.emitted},
            {"dropped", record.dropped},
            {"frames", record.frames.size()},
            {"ms_per_frame", mean_ms_per_frame(record)},
            {"wall_s", record.wall_s},
            {"peak_memory_mib", record.peak_memory_mib},
            {"provenance", provenance_of(mean_provenance(record))}};
  Json& stages = json["stages"] = Json::object();
  for (const StageSummary& stage : stage_summaries(record))
    stages[stage.name] = {{"frames", stage.frames},
                          {"mean_ms", stage.mean_ms},
                          {"p95_ms", stage.p95_ms},
                          {"max_ms", stage.max_ms}};
  if (!record.counters.empty()) json["counters"] = object_of(record.counters);
  if (!record.scores.empty()) {
    Json& scores = json["scores"] = Json::object();
    for (const ScoreRow& score : record.scores)
      scores[score.name] = {{"value", score.value}, {"unit", score.unit}};
  }
  if (record.response) json["response"] = *record.response;
  json["notes"] = record.notes;
  Json& frames = json["per_frame"] = Json::array();
  for (const FrameRecord& frame : record.frames) frames.push_back(json_of(frame));
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

Result<void> write_stats(Storage& storage, const std::string& path, const RunRecord& record) {
  const std::string json = to_json(record);
  return write_whole(storage, path, std::as_bytes(std::span(json)));
}

}  // namespace hdrcam
