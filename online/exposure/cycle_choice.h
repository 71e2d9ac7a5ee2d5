// Chooses the exposures that the next frames should have: the cycle for which the least error is expected
// (exposure_forecast.h), within the limits of the camera. Where things move, times get shorter and gains
// higher; where nothing does, times get longer. The least exposure stays, and with it the highlights that it
// keeps. Slots keep their number and their order, and stay far enough apart for the proof of their labels.
// The search takes one round per frame; the cycle changes only for a gain that is worth it, and then rests
// until frames of the new cycle are back. Thread-bound.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/exposure_limits.h"
#include "online/exposure/exposure_forecast.h"

namespace hdrcam {

// A cycle that is asked for, and why.
struct CycleRequest {
  std::vector<Exposure> cycle;
  double error_before = 0, error_after = 0;  // expected, of the mu-law, squared
  double blur_share = 0;                     // of error_before: what motion blur adds
};
// "1 ms, 2 ms x 2, 4 ms x 4: expected error -18 %; motion blur was 62 % of it before"
std::string describe(const CycleRequest& request);

class CycleChoice {
 public:
  // Of the error: a cycle that promises less than this is not worth the change.
  static constexpr double kLeastGain = 0.1;

  // state: what the state does with the frames of those exposures.
  CycleChoice(const ExposureLimits& limits, const StateOptions& state);

  // Once per emitted frame. Returns the next cycle where it should change, if the camera can do it.
  std::optional<CycleRequest> observe(const FrameEstimate& estimate, const ExposureForecast::Sensor& sensor);

  // From now on the camera is asked for that cycle.
  void runs(const CycleRequest& request);

  // The one that runs: the first one, or that of the last request that the camera took.
  const std::vector<Exposure>& cycle() const { return cycle_; }
  // How often it asked, and for what at last, in words.
  std::string summary() const;

 private:
  static constexpr int kSettling = 20;  // frames until those of a new cycle are back, and seen
  enum class Search { Waits, Coarse, Fine, Ends };

  void begin(const FrameEstimate& estimate, const ExposureForecast::Sensor& sensor);
  bool improve(double stops);
  std::optional<Exposure> fitted(std::size_t slot, double time_s, double gain) const;
  std::optional<Duration> fitted_time(std::size_t slot, Duration time) const;
  bool keeps_order(const std::vector<Exposure>& cycle) const;
  std::optional<CycleRequest> conclude();

  const ExposureLimits limits_;
  std::vector<double> gaps_;        // ln E between slots in order of E, of the first cycle: they stay as near
  std::vector<std::size_t> order_;  // of the slots, by E
  std::vector<Exposure> cycle_, better_;
  std::vector<Exposure> changed_, tried_;  // all slots of better_ changed alike, and some of them
  float first_white_ = 0;  // radiance that saturates the shortest exposure of the first cycle; 0: not known
  ScenePixels pixels_;
  ExposureForecast forecast_;
  ExposureForecast::SampleVariances variances_{}, changed_variances_{};  // of better_ and changed_
  double error_ = 0;                                                     // of better_
  Search search_ = Search::Waits;
  int requests_ = 0;
  std::string last_;  // request, in words
  int waiting_ = 8;   // at first, until the noise is known
};

}  // namespace hdrcam
