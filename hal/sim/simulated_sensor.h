// The sensor: a scene, a lens, and the effects of the plan in the order in which light, then charge meets
// them. An exposure goes in, codes come out:
//   light = flicker . flare . vignetting . mean radiance over the pixel and the exposure
//   electrons = N(light * seconds * sensitivity * full well + leaks), at most the capacity, plus read noise
//   code = quantised(response(gain * electrons / full well))
// A pixel holds a tenth more than the largest code stands for, or six read noises more where those are more,
// so that noise does not make a saturated pixel look unsaturated. An effect that the plan has off is not
// constructed. Thread-bound; allocates nothing after the first frame; the same simulation and shot give the
// same codes on any number of threads.
#pragma once

#include <memory>
#include <optional>

#include "hal/sim/effects/mosaic.h"
#include "hal/sim/effects/quantiser.h"
#include "hal/sim/scene_truth.h"
#include "hal/sim/simulation.h"

namespace hdrcam {

struct Shot {
  std::uint64_t sequence = 0;
  double begin_s = 0;  // scene time at which the first row opens
  double exposure_s = 0;
  double gain = 1;  // analogue
};

class SimulatedSensor {
 public:
  // layout: Rgb or a Bayer order, which brings the mosaic and rules out the response curve; bits: of a code,
  // 8..16. The pool outlives the sensor. `scene`: from another sensor with the same scene settings, to save
  // building it again.
  SimulatedSensor(const Simulation& simulation, PixelLayout layout, int bits, WorkerPool& pool,
                  std::shared_ptr<const Scene> scene = nullptr);

  const std::shared_ptr<const Scene>& scene() const { return scene_; }
  const Simulation& simulation() const {
    return simulation_;
  }  // as constructed: without what the layout rules out
  const Lens& lens() const { return lens_; }
  const Vignetting* vignetting() const { return vignetting_ ? &*vignetting_ : nullptr; }
  // Whether the effect acts on light or charge here. Effects of the stream belong to the camera.
  bool has(Effect effect) const;
  CameraFacts facts() const;

  // codes: [channels(layout), rows, cols], reshaped
  void expose(const Shot& shot, Image<std::uint16_t>& codes);
  // The light on the sensor in the last shot: [rgb, rows, cols].
  const Image<float>& light() const { return light_; }

 private:
  void gather(const Shot& shot);
  void read_out(const Shot& shot, Image<std::uint16_t>& codes);
  void read_row(const Shot& shot, int channel, int y, std::span<float> electrons) const;

  Simulation simulation_;
  PixelLayout layout_;
  int bits_;
  WorkerPool& pool_;
  std::shared_ptr<const Scene> scene_;
  Lens lens_;
  Renderer renderer_;
  Quantiser quantiser_;
  std::optional<Vignetting> vignetting_;
  std::optional<Flare> flare_;
  std::optional<MainsFlicker> flicker_;
  std::optional<Mosaic> mosaic_;
  std::optional<HotPixels> hot_pixels_;
  std::optional<Noise> noise_;
  std::optional<ResponseCurve> response_;
  Image<float> light_;        // [rgb, rows, cols]
  bool light_lasts_ = false;  // static: the next shot has the same light
  Image<float> electrons_;    // [1, rows, cols] scratch: one row per band of rows
};

}  // namespace hdrcam
