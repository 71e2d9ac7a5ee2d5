// Estimates response and black level from the first cycles of an alternating-exposure stream, given only the
// exposures: a robust MAP fit of g = ln x over 255 codes per channel, within two or three frames.
//   evidence   codes of two exposures that show the same light (histogram_matches.h, match_evidence.h)
//              the sensor's own noise, where the frames show it: its spread by code tells the curve's slope,
//              which a pair of exposures far apart hardly does (noise_levels.h, noise_evidence.h)
//   prior      real cameras (curve_prior.h)
//   shared     stated exposures are facts with an uncertainty: what each is off is fitted with the curves, as
//              far as the channels' matches disagree without it (shared_unknowns.h)
//   black      of each channel, where it is not stated: the level for which its matches agree best with each
//              other and with real cameras (black_level_search.h)
// Thread-bound.
#pragma once

#include <optional>
#include <vector>

#include "capture/exposed_frame.h"
#include "capture/noise_model.h"
#include "hal/core/black_level.h"
#include "hal/core/worker_pool.h"
#include "online/response/exposure_corrections.h"
#include "online/response/histogram_matches.h"
#include "online/response/noise_levels.h"
#include "online/response/response.h"

namespace hdrcam {

struct ResponseEstimate {
  Response response;
  BlackLevel black_level;
  ExposureCorrections exposures;
  std::optional<NoiseModel> noise;  // where the frames show the sensor's own (noise_levels.h)
  // Of the radiance, R G B, so that white is neutral, where the curves make it coloured because clipped
  // pixels are smeared (smeared_white.h); their product is 1.
  std::optional<ChannelGains> neutral_gains = {};
  // ln of the exposure of each of the first frames over the stated one, where light is unsteady
  // (first_light.h): then no exposure is corrected as such. Empty where it is steady.
  std::vector<float> light = {};
};

// What the curve may be.
enum class ResponseModel {
  Curve,    // 255 knots under the prior of real cameras
  Network,  // a small network without a prior
  Mean,     // the mean of real cameras, whatever the frames show
  Linear,   // none
};

class ResponseEstimator {
 public:
  // black_level: as the camera or user states it; none: it is estimated too.
  // code_step, bits: of the quantiser (noise_levels.h).
  explicit ResponseEstimator(std::optional<BlackLevel> black_level = std::nullopt, float code_step = 1,
                             int bits = 8)
      : stated_black_(black_level), noise_levels_(code_step, bits) {}

  // Frames come with their black level in them, unless the response is known (estimate_under).

  // Takes what the noise of a frame tells of the curve (noise_levels.h).
  void add_noise(const ExposedFrame& frame) { noise_levels_.add(frame); }

  // Adds the matches of two frames of different exposure; returns whether the pair counted
  // (histogram_matches.h).
  bool add_pair(const ExposedFrame& a, const ExposedFrame& b, SceneCuts cuts = SceneCuts::Possible) {
    return matches_.add(a, b, cuts);
  }

  // Pairs that counted. Without any, estimate() finds no black level, and of the curve what the sensor's own
  // noise tells; where frames do not show that either, the mean of real cameras.
  int pairs() const { return matches_.pairs(); }

  // Takes 50 to 100 ms of one thread, longer the more black levels are tried. `noise` gives the uncertainty
  // of the codes. Every model has the black level of the curve. pool: whose threads take a channel each; null
  // for the calling thread alone.
  ResponseEstimate estimate(const NoiseModel& noise, ResponseModel model = ResponseModel::Curve,
                            WorkerPool* pool = nullptr) const;

  // The same where the response is known, of frames with no black level left: what stated exposures are off,
  // and the noise. Takes some milliseconds.
  ResponseEstimate estimate_under(const Response& known, const NoiseModel& noise,
                                  WorkerPool* pool = nullptr) const;

 private:
  BlackLevel found_black(const NoiseModel& noise, WorkerPool* pool) const;

  std::optional<BlackLevel> stated_black_;
  NoiseLevels noise_levels_;
  HistogramMatches matches_;
};

// The mean of real camera responses: the assumption before any measurement.
Response prior_mean_response();

}  // namespace hdrcam
