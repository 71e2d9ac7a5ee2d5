#include "firmware_host/sinks/live_view/live_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "firmware_host/sinks/live_view/frame_picture.h"
#include "firmware_host/sinks/provenance_palette.h"
#include "firmware_host/sinks/record_json.h"
#include "firmware_host/version.h"
#include "hal/core/json_text.h"
#include "render/half.h"
#include "render/srgb.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kDropped = "dropped.";

// As the file stores it.
float stored(float radiance) { return static_cast<float>(as_half(radiance)); }

std::vector<int> radiance_histogram(const Image<float>& radiance) {
  std::vector<int> bins(kHistogramBins);
  for (std::size_t i = 0; i < radiance.plane_size(); ++i) {
    const double stops = stops_of(luminance_at(radiance, i));
    const double place = (stops - kLeastStop) * kHistogramBins / (kMostStop - kLeastStop);
    ++bins[static_cast<std::size_t>(std::clamp(place, 0.0, kHistogramBins - 1.0))];
  }
  return bins;
}

Json frame_json(const ShownFrame& frame) {
  const FrameFacts& facts = frame.hdr.facts;
  Json json{{"sequence", facts.sequence},
            {"time_s", frame.record.time_s},
            {"width", frame.hdr.radiance.cols()},
            {"height", frame.hdr.radiance.rows()},
            {"exposure_s", facts.exposure_s},
            {"gain", facts.gain()},
            {"relative_exposure", frame.hdr.exposure},
            {"total_ms", frame.record.total_ms},
            {"stages_ms", object_of(frame.record.stages_ms)},
            {"histogram", radiance_histogram(frame.hdr.radiance)}};
  if (facts.verdict) json["verdict"] = name(*facts.verdict);
  json["provenance"] = provenance_of(frame.record.provenance_share);
  return json;
}

double seconds_between(EmissionFigures::Clock::time_point from, EmissionFigures::Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

// Prometheus' text format: of each family of metrics its help and type, then its samples.
class Exposition {
 public:
  void family(std::string_view name, std::string_view type, std::string_view help) {
    text_ += fmt::format("# HELP {0} {2}\n# TYPE {0} {1}\n", name, type, help);
  }
  void sample(std::string_view name, double value) { text_ += fmt::format("{} {}\n", name, value); }
  void sample(std::string_view name, std::string_view label, std::string_view word, double value) {
    text_ += fmt::format("{}{{{}=\"{}\"}} {}\n", name, label, word, value);
  }
  void single(std::string_view name, std::string_view type, std::string_view help, double value) {
    family(name, type, help);
    sample(name, value);
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

// The counters of the camera; without one, the frames that were emitted are all there is.
void add_frames(const LiveFigures& figures, Exposition& out) {
  const auto counter = [&](std::string_view name) {
    const auto found = std::ranges::find(figures.counters, name, &NamedValue::name);
    return found == figures.counters.end() ? 0 : found->value;
  };
  const bool camera = !figures.counters.empty();
  const auto emitted = static_cast<double>(figures.emission.frames);
  out.single("hdrcam_frames_emitted_total", "counter", "HDR frames that left the pipeline.",
             camera ? counter("emitted") : emitted);
  out.family("hdrcam_exposures_total", "counter", "Frames by the verdict on their exposure.");
  for (const Verdict verdict : kVerdicts) {
    const std::string key = fmt::format("camera.{}", name(verdict));
    const auto seen = static_cast<double>(figures.emission.verdicts[static_cast<std::size_t>(verdict)]);
    out.sample("hdrcam_exposures_total", "verdict", name(verdict), camera ? counter(key) : seen);
  }
  if (!camera) return;
  out.single("hdrcam_frames_captured_total", "counter", "Frames that the camera delivered.",
             counter("captured"));
  out.single("hdrcam_frames_recorded_total", "counter", "Raw frames in a recording.", counter("recorded"));
  out.single("hdrcam_frames_lost_total", "counter", "Frames that never came from the camera.",
             counter("camera.lost"));
  out.family("hdrcam_frames_dropped_total", "counter", "Captured frames without an HDR frame, by reason.");
  for (const NamedValue& value : figures.counters)
    if (value.name.starts_with(kDropped))
      out.sample("hdrcam_frames_dropped_total", "reason", value.name.substr(kDropped.size()), value.value);
}

}  // namespace

std::string pixel_json(const ShownFrame& frame, int x, int y) {
  const Image<float>& radiance = frame.hdr.radiance;
  const float rgb[] = {stored(radiance.at(0, y, x)), stored(radiance.at(1, y, x)),
                       stored(radiance.at(2, y, x))};
  const Json json{{"sequence", frame.hdr.facts.sequence},
                  {"x", x},
                  {"y", y},
                  {"radiance", {rgb[0], rgb[1], rgb[2]}},
                  {"stops", stops_of(luminance(rgb[0], rgb[1], rgb[2]))},
                  {"sigma", frame.hdr.sigma.at(0, y, x)},
                  {"provenance", kProvenanceLooks[frame.hdr.provenance.at(0, y, x)].name}};
  return json_text(json);
}

std::string status_json(const LiveFigures& figures) {
  const EmissionFigures& emission = figures.emission;
  Json json{{"hdrcam", kVersion},
            {"frames", emission.frames},
            {"frames_per_second", emission.per_second},
            {"latency_ms", emission.latency_ms},
            {"running_s", seconds_between(emission.begin, EmissionFigures::Clock::now())},
            {"stops", {kLeastStop, kMostStop}},
            {"counters", counters_of(figures.counters)},
            {"recording", figures.recording}};
  Json& verdicts = json["verdicts"] = Json::object();
  for (const Verdict verdict : kVerdicts)
    verdicts[name(verdict)] = emission.verdicts[static_cast<std::size_t>(verdict)];
  Json& cycle = json["exposures"] = Json::array();
  for (const ExposureInUse& exposure : emission.exposures)
    cycle.push_back({{"time_s", exposure.time_s},
                     {"gain", exposure.gain},
                     {"saturates_at_stops", std::log2(1 / exposure.relative)}});
  Json& stages = json["mean_stages_ms"] = Json::object();
  for (const NamedValue& stage : emission.stages_ms)
    stages[std::string(stage.name)] = stage.value / static_cast<double>(emission.frames);
  if (figures.frame != nullptr) json["frame"] = frame_json(*figures.frame);
  return json_text(json);
}

std::string prometheus_text(const LiveFigures& figures) {
  const EmissionFigures& emission = figures.emission;
  const auto now = EmissionFigures::Clock::now();
  Exposition out;
  add_frames(figures, out);
  out.family("hdrcam_stage_seconds_total", "counter", "Time that each stage of the pipeline took.");
  for (const NamedValue& stage : emission.stages_ms)
    out.sample("hdrcam_stage_seconds_total", "stage", stage.name, stage.value * 1e-3);
  out.single("hdrcam_processing_seconds_total", "counter", "Time that the pipeline took for all frames.",
             emission.processing_ms * 1e-3);
  out.single("hdrcam_frames_per_second", "gauge", "HDR frames per second, of the latest frames.",
             emission.per_second);
  out.single("hdrcam_latency_seconds", "gauge", "From the newest frame's arrival to its emission.",
             emission.latency_ms * 1e-3);
  if (emission.frames > 0)
    out.single("hdrcam_newest_frame_age_seconds", "gauge", "Time since the newest HDR frame.",
               seconds_between(emission.newest, now));
  if (figures.frame != nullptr) {
    out.family("hdrcam_provenance_share", "gauge", "Share of the newest frame's pixels by their source.");
    for (std::size_t i = 0; i < kProvenances; ++i)
      out.sample("hdrcam_provenance_share", "source", kProvenanceLooks[i].key,
                 static_cast<double>(figures.frame->record.provenance_share[i]));
  }
  out.single("hdrcam_uptime_seconds", "gauge", "Time since the start of the run.",
             seconds_between(emission.begin, now));
  out.single("hdrcam_peak_memory_bytes", "gauge", "Largest resident memory so far.",
             peak_memory_mib() * 1024 * 1024);
  out.family("hdrcam_build_info", "gauge", "The version of the program.");
  out.sample("hdrcam_build_info", "version", kVersion, 1);
  return std::move(out).text();
}

}  // namespace hdrcam
