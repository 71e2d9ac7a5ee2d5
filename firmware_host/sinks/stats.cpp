#include "firmware_host/sinks/stats.h"

#include <nlohmann/json.hpp>
#include <span>

#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/record_json.h"
#include "firmware_host/version.h"
#include "hal/core/cpu.h"
#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBlanks = 1;  // a level

// Of a run with a deadline: what the governor chose.
Json deadline_of(const RunRecord& record) {
  Json rungs = Json::array();
  for (const RungRecord& rung : record.rungs) rungs.push_back({{"name", rung.name}, {"frames", rung.frames}});
  return {{"late", record.late}, {"left_out", record.left_out}, {"rungs", rungs}};
}

Json json_of(const FramePose& pose) {
  Json json{{"source", name(pose.source)},
            {"length_unit", name(unit_of(pose.source))},
            {"T_world_camera", pose_matrix_of(pose.T_world_camera)}};
  if (pose.lost) json["lost"] = true;
  if (pose.world > 0) json["world"] = pose.world;
  return json;
}

Json json_of(const FrameRecord& frame, const RunRecord& run) {
  Json json{{"sequence", frame.sequence},        {"time_s", frame.time_s},
            {"exposure", frame.exposure},        {"total_ms", frame.total_ms},
            {"fit_steps", frame.fit_steps},      {"stages_ms", object_of(frame.stages_ms)},
            {"losses", object_of(frame.losses)}, {"provenance", provenance_of(frame.provenance_share)}};
  if (!run.rungs.empty()) json["rung"] = frame.rung;
  json["exposure_source"] = name(frame.exposure_source);
  if (frame.verdict) json["verdict"] = name(*frame.verdict);
  if (frame.pose) json["pose"] = json_of(*frame.pose);
  if (frame.latency_ms > 0) json["latency_ms"] = frame.latency_ms;
  if (!frame.note.empty()) json["note"] = frame.note;
  return json;
}

// As the last member of the object in `text`. One JSON value of all frames would take more memory than their
// records and their text together.
void add_frames(const RunRecord& record, std::string& text) {
  text.resize(text.rfind("\n}"));
  text += ",\n \"per_frame\": [";
  for (const FrameRecord& frame : record.frames) {
    text += &frame == &record.frames.front() ? "\n  " : ",\n  ";
    for (const char c : json_text(json_of(frame, record), kBlanks)) {
      text += c;
      if (c == '\n') text += "  ";
    }
  }
  text += record.frames.empty() ? "]\n}" : "\n ]\n}";
}

Json stages_of(const RunRecord& record) {
  Json stages = Json::object();
  for (const StageSummary& stage : stage_summaries(record))
    stages[stage.name] = {{"frames", stage.frames},
                          {"mean_ms", stage.mean_ms},
                          {"p95_ms", stage.p95_ms},
                          {"max_ms", stage.max_ms}};
  return stages;
}

Json sinks_of(const RunRecord& record) {
  Json sinks = Json::object();
  for (const SinkTimes& sink : record.sinks)
    sinks[sink.name] = {{"frames", sink.frames},
                        {"mean_ms", sink.mean_ms()},
                        {"max_ms", sink.longest_ms},
                        {"left_out", sink.left_out}};
  return sinks;
}

Json scores_of(const RunRecord& record) {
  Json scores = Json::object();
  for (const ScoreRow& score : record.scores)
    scores[score.name] = {{"value", score.value}, {"unit", score.unit}};
  return scores;
}

// What pictures say about the stated ones.
Json exposures_of(const RunRecord& record) {
  Json exposures = Json::array();
  for (const auto& [stated, stops] : record.exposures)
    exposures.push_back({{"stated", stated}, {"off_stops", stops}});
  return exposures;
}

class Stats : public FrameSink {
 public:
  Stats(Storage& storage, std::string path) : storage_(storage), path_(std::move(path)) {}

  Result<void> emit(const EmittedFrame&) override { return {}; }
  Result<void> conclude(const RunRecord& record) override {
    const std::string json = to_json(record);
    return write_whole(storage_, path_, std::as_bytes(std::span(json)));
  }

 private:
  Storage& storage_;
  const std::string path_;
};

}  // namespace

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
  if (!record.rungs.empty()) json["deadline"] = deadline_of(record);
  json["stages"] = stages_of(record);
  json["sinks"] = sinks_of(record);
  if (!record.counters.empty()) json["counters"] = counters_of(record.counters);
  if (!record.scores.empty()) json["scores"] = scores_of(record);
  if (record.response) json["response"] = *record.response;
  if (!record.exposures.empty()) json["exposures"] = exposures_of(record);
  if (record.light_spread_stops > 0) json["light_spread_stops"] = record.light_spread_stops;
  json["notes"] = record.notes;
  std::string text = json_text(json, kBlanks);
  add_frames(record, text);
  return text + '\n';
}

Result<std::unique_ptr<FrameSink>> create_stats(Storage& storage, const std::string& path) {
  TRY(make_folder_of(storage, path));
  return std::unique_ptr<FrameSink>(std::make_unique<Stats>(storage, path));
}

}  // namespace hdrcam
