// Estimates response and black level from the first cycles of an alternating-exposure stream, given only the
// exposures. Neighbouring frames show about the same scene, so their histograms match: the share q of the
// pixels that is darker than code z1 in one, at exposure E1, is darker than z2 in the other, at E2; so g(z1)
// - g(z2) = ln E1/E2 with g = ln x. It matches the boundaries between codes, whose place in a histogram is
// exact, not codes, which are half a step wide at worst. A robust MAP fit of g over 255 codes per channel,
// under a prior from real cameras (dorf_prior.inc), gives a result within two or three frames; no alignment,
// no flow (flow-matched samples made it worse: docs/decisions.md). Stated exposures are facts with an
// uncertainty: what each is off is fitted with the curves, as far as the channels' matches disagree without
// it. It chooses the black level of each channel for which its matches agree best with each other and with
// real cameras. Where the frames show the sensor's own noise, its spread by code tells the curve's slope, too
// (noise_evidence.h): a pair of exposures far apart hardly does. Thread-bound.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "capture/noise_model.h"
#include "capture/unpack.h"
#include "online/response/noise_levels.h"
#include "online/response/response.h"

namespace hdrcam {

// What stated exposures are off: cameras round shutter times to nominal ones. By the stated exposure.
class ExposureCorrections {
 public:
  void set(float exposure, double log_ratio) { log_ratios_[key(exposure)] = log_ratio; }
  // What the exposure really was; as stated where nothing is known of it.
  float corrected(float exposure) const;
  // In 1/64 stop: exposures that differ by less are one.
  static int key(float exposure);

 private:
  std::map<int, double> log_ratios_;  // ln of true over stated
};

struct ResponseEstimate {
  Response response;
  BlackLevel black_level;
  ExposureCorrections exposures;
  std::optional<NoiseModel> noise;  // where the frames show the sensor's own (noise_levels.h)
};

// What the curve may be.
enum class ResponseModel {
  Curve,    // 255 knots under the prior of real cameras
  Network,  // a small network without a prior
  Mean,     // the mean of real cameras, whatever the frames show
  Linear,   // none
};

// Whether a pair may span a cut: then it counts only where both frames seem to show one scene.
enum class SceneCuts { Possible, None };

class ResponseEstimator {
 public:
  static constexpr int kQuantiles = 400;       // matches per pair and channel
  static constexpr float kMaxBlackLevel = 24;  // codes: above, dark pixels are a bright scene

  // black_level: as the camera or user states it; none: it is estimated too.
  // code_step: of the quantiser, in codes of 255.
  explicit ResponseEstimator(std::optional<BlackLevel> black_level = std::nullopt, float code_step = 1)
      : stated_black_(black_level), noise_levels_(code_step) {}

  // Takes what the noise of a frame tells of the curve (noise_levels.h), unpacked without a black level.
  void add_noise(const ExposedFrame& frame) { noise_levels_.add(frame); }

  // Adds the matches of two frames of different exposure, unpacked without a black level. It skips frames of
  // (nearly) the same exposure, of unproved exposure, or of different scenes (a cut); returns whether the
  // pair counted.
  bool add_pair(const ExposedFrame& a, const ExposedFrame& b, SceneCuts cuts = SceneCuts::Possible);

  // Pairs that counted. Without any, estimate() returns the mean of real cameras and no black level.
  int pairs() const { return pairs_; }

  // Takes 50 to 100 ms, the more levels are tried. `noise` gives the uncertainty of the codes. Every model
  // has the black level of the curve.
  ResponseEstimate estimate(const NoiseModel& noise, ResponseModel model = ResponseModel::Curve) const;

 private:
  struct Match {
    float z1, z2;  // codes of the shorter and of the longer exposure
  };
  struct Matches {
    double log_ratio = 0;  // ln E1/E2 < 0
    std::vector<Match> codes;
  };
  struct MatchNoise {
    NoiseModel model;
    bool is_own = false;  // of the sensor: no compression or filter took it away, and it widens histograms
  };
  struct Curve;      // of one channel
  struct Agreement;  // of a curve with the matches
  struct Fit;        // all channels and exposures

  static void keep_newest(std::vector<Match>& matches);
  std::vector<int> exposure_keys() const;
  float find_black_level(std::size_t channel, const NoiseModel& noise) const;
  void add_matches(std::size_t channel, float black_level, const MatchNoise& noise, const Eigen::VectorXd& g,
                   const std::vector<int>& keys, const Eigen::VectorXd& shared, Agreement& agreed) const;
  Agreement agreement(std::size_t channel, float black_level, const MatchNoise& noise,
                      const Eigen::VectorXd& g, const std::vector<int>& keys,
                      const Eigen::VectorXd& shared) const;
  Agreement agreement_at(float black_level, std::size_t channel, const NoiseModel& noise) const;
  Fit solve(const BlackLevel& black_level, const NoiseModel& noise) const;

  std::optional<BlackLevel> stated_black_;
  NoiseLevels noise_levels_;
  int pairs_ = 0;
  float shortest_ = 0;  // exposure
  // Codes of the shortest exposure: hardly a pixel is darker; no black level is above.
  std::array<float, 3> darkest_{}, most_black_{};
  std::array<std::map<std::pair<int, int>, Matches>, 3> matches_;  // by exposures in 1/64 stop
};

// The mean of real camera responses: the assumption before any measurement.
Response prior_mean_response();

}  // namespace hdrcam
