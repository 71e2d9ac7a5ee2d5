// The record of a run, for users and scripts: facts of the clip and one entry per emitted frame. The run
// fills it (run/run.h), --stats writes it as JSON (stats.h) and the report draws it (report.h). Plain values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/inline_list.h"
#include "online/response/exposure_corrections.h"
#include "online/response/response.h"
#include "render/hdr_frame.h"

namespace hdrcam {

struct NamedValue {
  std::string_view name;  // of static storage
  double value = 0;
};

// One frame's values: room for all stages, or all terms of the fit.
using FrameValues = InlineList<NamedValue, 24>;

// To the value of that name, which is appended where there is none.
void add_to(FrameValues& values, const NamedValue& more);

struct FrameRecord {
  std::uint64_t sequence = 0;
  double time_s = 0;    // since the first frame
  double exposure = 1;  // E / E_ref
  ExposureSource exposure_source = ExposureSource::Unknown;
  std::optional<Verdict> verdict;  // on the exposure; none: not judged
  // The sum of stages_ms; of a saved scene's film, which has none: since the frame before.
  double total_ms = 0;
  // By name(Stage), in the order of the pipeline; a stage that did not run may be missing.
  FrameValues stages_ms;
  FrameValues losses;  // weighted terms of the fit, mean over the frame's steps; empty without a step
  int fit_steps = 0;
  int rung = 0;           // of RunRecord::rungs; 0 without a deadline
  double latency_ms = 0;  // from the frame's arrival to its emission, on a camera; 0 in a replay
  std::array<float, kProvenances> provenance_share{};  // of the pixels, by enum Provenance, sums to 1
  std::optional<FramePose> pose;                       // none where it is not known
  std::string note;  // unusual events in words: "step rolled back"; usually empty
};

// What the frame itself tells: its number, exposure, verdict, pose and provenance. time_s: since the first
// frame. The work on it is for others to fill in.
void describe_frame(const HdrFrame& frame, double time_s, FrameRecord& record);

// [rgb][code] relative exposure, as Response::inverse
using ResponseCurves = std::array<Response::Curve, 3>;

// One choice of the governor: what it gave up, and for how many frames.
struct RungRecord {
  std::string name;  // "as asked" first, then what each gives up beyond the one before
  int frames = 0;
};

struct ScoreRow {
  std::string name;  // "PSNR-mu"
  std::string unit;  // "dB"; "" for a pure number
  double value = 0;
  bool higher_is_better = true;
};

// The cost of one sink, on its own thread or the emitting one.
struct SinkTimes {
  std::string name = {};
  int frames = 0;    // that it received
  int left_out = 0;  // because it could not keep up with a camera
  double total_ms = 0, longest_ms = 0;

  double mean_ms() const { return frames > 0 ? total_ms / frames : 0; }
};

struct RunRecord {
  std::string title;    // usually the clip's name
  std::string command;  // that makes the run again
  std::string preset;
  std::uint64_t seed = 0;
  int threads = 1;

  std::string camera;
  int width = 0, height = 0;
  double framerate_hz = 0;
  double deadline_ms = 0;         // per frame; 0: none
  std::vector<RungRecord> rungs;  // of a run with a deadline
  int late = 0, left_out = 0;     // frames over the deadline; frames not emitted to hold it

  int captured = 0, emitted = 0, dropped = 0;  // captured = emitted + dropped; the report checks it
  // Frames by stage and reason, "dropped.shed"; of a recording the damaged ones alone.
  std::vector<NamedValue> counters;
  double wall_s = 0;
  double peak_memory_mib = 0;

  std::vector<FrameRecord> frames;
  std::vector<SinkTimes> sinks;
  std::optional<ResponseCurves> response;         // the estimate in use at the end
  std::optional<Response::Curve> response_prior;  // the mean of the prior, the same for each channel
  std::vector<ExposureCorrection> exposures;      // what pictures say about the stated ones
  double light_spread_stops = 0;                  // SensorModel
  std::vector<ScoreRow> scores;                   // empty without ground truth
  std::uint64_t film_pixels = 0;                  // of all frames of a film
  std::uint64_t film_pixels_from_field = 0;       // those of them that no recorded frame shows
  std::vector<std::string> notes;  // remarks on the clip, such as what was switched off and why
};

// One stage over all frames in which it ran.
struct StageSummary {
  std::string name;
  int frames = 0;
  double mean_ms = 0, p95_ms = 0, max_ms = 0;
};

// In the order in which the stages first occur; the last entry is "total".
std::vector<StageSummary> stage_summaries(const RunRecord& record);

// The work of the method on a frame: all stages but the sinks.
StageSummary method_summary(const RunRecord& record);

// Mean of total_ms; 0 without frames.
double mean_ms_per_frame(const RunRecord& record);

// Share of each provenance over the whole run.
std::array<double, kProvenances> mean_provenance(const RunRecord& record);

// Peak resident memory of this process so far, MiB.
double peak_memory_mib();

}  // namespace hdrcam
