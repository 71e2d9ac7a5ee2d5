// The error that HDR frames will have if the camera runs a given cycle, predicted for the pixels of
// scene_pixels.h: each pixel's variance is carried from frame to frame as the state carries it (StateFilter),
// through the noise of every exposure at its gain, its clipping and its blur. The error is squared and of the
// mu-law of radiance (online/mu_law.h), as pictures are judged: -10 log10 of it is a PSNR-mu. Thread-bound;
// no allocation.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "capture/exposure_schedule.h"
#include "online/exposure/scene_pixels.h"
#include "online/state/exposure_tables.h"
#include "online/state/state_filter.h"

namespace hdrcam {

class ExposureForecast {
 public:
  using Values = ScenePixels::Values;
  // The variance of one slot's samples, pixel by pixel; what is clipped has a huge one.
  using SampleVariances = std::array<Values, ExposureSchedule::kMaxSlots>;

  enum class Blur { Counted, LeftOut };

  // What the fit knows of the sensor.
  struct Sensor {
    const Response& response;
    const NoiseModel& noise;  // at reference_gain
    double reference_gain;
  };

  // state: what the state does with its samples.
  explicit ExposureForecast(const StateOptions& state) : state_(state) {}

  // Looks at the pixels, which must stay as they are while this forecast is asked. Errors count up to the
  // radiance `white`. reference_exposure: E_ref, seconds x gains.
  void look(const ScenePixels& pixels, const Sensor& sensor, double reference_exposure, float white);

  // Of one exposure at each pixel.
  void sample_variances(const Exposure& exposure, Blur blur, Values& variances) const;
  // Of a cycle whose slots have these variances.
  double error(std::span<const Values* const> slots) const;
  // Both in one.
  double error(std::span<const Exposure> cycle, Blur blur);

 private:
  const StateOptions state_;
  const ScenePixels* pixels_ = nullptr;
  std::optional<ExposureTables> tables_;  // at E = E_ref, without shot and read noise
  NoiseModel noise_;
  double reference_exposure_ = 1, reference_gain_ = 1;
  Values weight_{};  // squared slope of the mu-law
  SampleVariances variances_{};
};

}  // namespace hdrcam
