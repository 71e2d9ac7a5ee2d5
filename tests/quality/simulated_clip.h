// A small simulated clip with ground truth, and the pipeline's result. The program's own `simulate` verb
// films it, so that its truth is the one that `hdrcam compare` reads. The same text gives the same clip on
// every machine. Thread-bound; everything is in memory except the truth, whose folder is removed at the end
// of the run.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "firmware_host/run/pipeline.h"
#include "firmware_host/sinks/run_record.h"
#include "render/scores/scores.h"

namespace hdrcam::test {

struct SimulatedClip {
  std::string folder;  // clip.json and gt/, as score_clip reads them
  CameraFacts camera;
  std::vector<RawFrame> frames;
};

// scene: "walk?size=128x96"; shutter: "1ms,4ms,16ms"
SimulatedClip film(const std::string& scene, const std::string& shutter, int frames,
                   const std::string& format = "rgb");

struct EmittedClip {
  std::vector<HdrFrame> frames;  // radiance, sigma and provenance only
  int fit_steps = 0;             // over all frames
};

EmittedClip emit(const SimulatedClip& clip, const PipelineOptions& options);

// As `hdrcam compare` gives them.
ClipScores scores_of(const SimulatedClip& clip, const EmittedClip& emitted);

// Checks the stated uncertainty over all pixels that are not white.
struct Calibration {
  // Squared error of ln radiance over the variance that the frame claims (sigma squared).
  struct Ratio {
    double median, of_sums;
    int pixels;
  };
  static constexpr int kFewPixels = 500;
  std::array<std::optional<Ratio>, kProvenances> ratios;  // none where too few pixels have it
  double bounds_kept = 1;  // share of the pixels called a bound whose truth is not below nine tenths of it
};
// scores: of the same frames; their gains make estimate and truth comparable.
Calibration calibration_of(const SimulatedClip& clip, const EmittedClip& emitted, const ClipScores& scores);

}  // namespace hdrcam::test
