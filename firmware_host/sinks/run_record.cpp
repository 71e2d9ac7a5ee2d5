#include "firmware_host/sinks/run_record.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <string>

#include "hal/core/stage_timing.h"

namespace hdrcam {
namespace {

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

}  // namespace

void add_to(FrameValues& values, const NamedValue& more) {
  for (NamedValue& value : values)
    if (value.name == more.name) {
      value.value += more.value;
      return;
    }
  values.push_back(more);
}

void describe_frame(const HdrFrame& frame, double time_s, FrameRecord& record) {
  record.sequence = frame.facts.sequence;
  record.time_s = time_s;
  record.exposure = static_cast<double>(frame.exposure);
  record.exposure_source = frame.facts.exposure_source;
  record.verdict = frame.facts.verdict;
  record.pose = frame.pose;
  record.provenance_share = provenance_shares(frame.provenance);
}

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

StageSummary method_summary(const RunRecord& record) {
  std::vector<double> times_ms;
  for (const FrameRecord& frame : record.frames) {
    times_ms.push_back(frame.total_ms);
    for (const NamedValue& stage : frame.stages_ms)
      if (stage.name == name(Stage::Sinks)) times_ms.back() -= stage.value;
  }
  return summary_of("method", std::move(times_ms));
}

double mean_ms_per_frame(const RunRecord& record) {
  double sum_ms = 0;
  for (const FrameRecord& frame : record.frames) sum_ms += frame.total_ms;
  return record.frames.empty() ? 0 : sum_ms / static_cast<double>(record.frames.size());
}

// Sums are divided once, so that the mean is 1 where every share is.
std::array<double, kProvenances> mean_provenance(const RunRecord& record) {
  std::array<double, kProvenances> shares{};
  for (const FrameRecord& frame : record.frames)
    for (std::size_t i = 0; i < kProvenances; ++i)
      shares[i] += static_cast<double>(frame.provenance_share[i]);
  for (double& share : shares) share /= static_cast<double>(std::max<std::size_t>(1, record.frames.size()));
  return shares;
}

// Not getrusage(): its figure takes along that of the process that started this one.
double peak_memory_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == "VmHWM:") {
      double kib = 0;
      status >> kib;
      return kib / 1024;
    }
  return 0;
}

}  // namespace hdrcam
