// An example run for reports and statistics: a clip of `frames` frames with three exposures. Formulas give
// the numbers; none is random.
#pragma once

#include <cmath>

#include "firmware_host/sinks/run_record.h"

namespace hdrcam::test {

inline ResponseCurves example_response() {
  ResponseCurves curves;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t code = 0; code < curves[c].size(); ++code)
      curves[c][code] = std::pow(static_cast<float>(code) / 255, 2.0f + 0.15f * static_cast<float>(c));
  return curves;
}

inline RunRecord example_run(int frames) {
  RunRecord record;
  record.title = "walk <demo> & more";
  record.command = "hdrcam replay walk.mkv -o 'out/%06d.exr'";
  record.preset = "balanced";
  record.seed = 7;
  record.threads = 2;
  record.camera = "walk";
  record.width = 320, record.height = 240;
  record.framerate_hz = 30;
  record.deadline_ms = 100;
  record.captured = frames, record.emitted = frames;
  record.wall_s = 4.2;
  record.peak_memory_mib = 120;
  for (int i = 0; i < frames; ++i) {
    FrameRecord frame;
    frame.sequence = static_cast<std::uint64_t>(i);
    frame.time_s = i / 30.0;
    frame.exposure = std::exp2(2.0 * (i % 3 - 1));
    const double wobble = std::sin(i * 0.7);
    frame.stages_ms = {{"flow", 14 + wobble},
                       {"state", 9 + 2 * wobble},
                       {"field", 38 + 9 * std::cos(i * 0.3)},
                       {"emission", 11 - wobble},
                       {"sinks", 6.5}};
    for (const NamedValue& stage : frame.stages_ms) frame.total_ms += stage.value;
    frame.losses = {{"photometric", 0.08 / (1 + i * 0.2)},
                    {"state", 0.03 / (1 + i * 0.1)},
                    {"flow", 0.004 + 0.001 * wobble},
                    {"smoothness", 0.0006}};
    frame.fit_steps = 128;
    const float carried = 0.6f * (1 - std::exp(-static_cast<float>(i) / 4));
    frame.provenance_share = {0.9f - carried, carried, 0.06f, 0.03f, 0.01f};
    record.frames.push_back(frame);
  }
  record.response = example_response();
  record.response_prior = example_response()[1];
  record.exposures = {{0.25f, 0.03f}, {1, -0.06f}, {4, 0.03f}};
  record.scores = {
      {"PSNR-mu", "dB", 38.1, true}, {"flicker", "stops", 0.059, false}, {"SSIM", "", 0.98, true}};
  record.notes = {"the camera stands still: no poses are tracked"};
  if (frames > 5) record.frames[5].note = "a step was rolled back";
  return record;
}

}  // namespace hdrcam::test
