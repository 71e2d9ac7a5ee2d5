#include "hal/sim/simulated_sensor.h"

#include <algorithm>
#include <bit>

namespace hdrcam {
namespace {

// Electrons that a pixel holds: beyond the largest code, so that a full one is read as saturated.
float capacity_e(const Simulation& s) {
  constexpr float kCapacity = 1.1f;  // full wells
  constexpr float kReadNoises = 6;   // at least, where few electrons fill a well
  return std::max(kCapacity * s.full_well_e, s.full_well_e + kReadNoises * s.noise.read_noise_e);
}

// What the stream's format decides.
Simulation for_layout(Simulation simulation, PixelLayout layout) {
  const bool raw = layout != PixelLayout::Rgb;
  if (!raw) return simulation.plan.switch_off(Effect::Mosaic, "the stream is RGB"), simulation;
  simulation.plan.switch_on(Effect::Mosaic, "the stream is raw Bayer");
  simulation.plan.switch_off(Effect::Response, "a raw stream is linear");
  return simulation;
}

// Texels of the surroundings as fine as the picture's pixels, within limits.
int face_px(int width) {
  return static_cast<int>(std::bit_floor(static_cast<unsigned>(std::clamp(width * 8 / 5, 32, 512))));
}

template <class T, class... Args>
std::optional<T> if_on(const EffectPlan& plan, Effect effect, Args&&... args) {
  return plan.on(effect) ? std::optional<T>(std::in_place, std::forward<Args>(args)...) : std::nullopt;
}

Lens lens_of(const Simulation& s) {
  return {centred_intrinsics(s.width, s.height, s.view_deg * std::numbers::pi / 180),
          if_on<Distortion>(s.plan, Effect::Distortion, s.distortion)};
}

ShutterEffects shutter_of(const Simulation& s) {
  return {
      if_on<MotionBlur>(s.plan, Effect::MotionBlur, s.motion_blur),
      if_on<RollingShutter>(s.plan, Effect::RollingShutter, RollingShutterSettings{s.readout()}, s.height)};
}

}  // namespace

SimulatedSensor::SimulatedSensor(const Simulation& simulation, PixelLayout layout, int bits, WorkerPool& pool,
                                 std::shared_ptr<const Scene> scene)
    : simulation_(for_layout(simulation, layout)),
      layout_(layout),
      bits_(bits),
      pool_(pool),
      scene_(scene ? std::move(scene)
                   : std::make_shared<Scene>(make_scene(simulation.scene, face_px(simulation.width), pool))),
      lens_(lens_of(simulation_)),
      renderer_(*scene_, lens_, shutter_of(simulation_), simulation.height, simulation.width, pool,
                simulation.sampling),
      quantiser_(bits, simulation.black_level * static_cast<float>((1 << bits) - 1)) {
  const Simulation& s = simulation_;
  const std::uint64_t seed = s.scene.seed;
  vignetting_ =
      if_on<Vignetting>(s.plan, Effect::Vignetting, s.vignetting, lens_.intrinsics, s.height, s.width);
  flare_ = if_on<Flare>(s.plan, Effect::Flare, s.flare, s.height, s.width);
  flicker_ = if_on<MainsFlicker>(s.plan, Effect::MainsFlicker, s.mains_flicker);
  if (s.plan.on(Effect::Mosaic)) mosaic_.emplace(layout);
  hot_pixels_ =
      if_on<HotPixels>(s.plan, Effect::HotPixels, s.hot_pixels, seed, channels(layout), s.height, s.width);
  noise_ = if_on<Noise>(s.plan, Effect::Noise, s.noise, seed);
  response_ = if_on<ResponseCurve>(s.plan, Effect::Response, s.response);
}

bool SimulatedSensor::has(Effect effect) const {
  switch (effect) {
    case Effect::MotionBlur:
      return renderer_.shutter().blur.has_value();
    case Effect::RollingShutter:
      return renderer_.shutter().rolling.has_value();
    case Effect::Distortion:
      return lens_.distortion.has_value();
    case Effect::Vignetting:
      return vignetting_.has_value();
    case Effect::Flare:
      return flare_.has_value();
    case Effect::MainsFlicker:
      return flicker_.has_value();
    case Effect::Mosaic:
      return mosaic_.has_value();
    case Effect::HotPixels:
      return hot_pixels_.has_value();
    case Effect::Noise:
      return noise_.has_value();
    case Effect::Quantisation:
      return true;
    case Effect::Response:
      return response_.has_value();
    case Effect::ControlDelay:
    case Effect::Drops:
    case Effect::ClockJitter:
      break;
  }
  return false;
}

CameraFacts SimulatedSensor::facts() const {
  CameraFacts facts;
  facts.name = scene_->name;
  facts.width = simulation_.width, facts.height = simulation_.height;
  facts.framerate_hz = simulation_.framerate_hz;
  facts.bits = bits_;
  facts.layout = layout_;
  facts.linear = !response_;
  facts.intrinsics = lens_.intrinsics;
  return facts;
}

void SimulatedSensor::expose(const Shot& shot, Image<std::uint16_t>& codes) {
  if (!light_lasts_) gather(shot), light_lasts_ = !scene_->moves();
  read_out(shot, codes);
}

void SimulatedSensor::gather(const Shot& shot) {
  renderer_.render({shot.begin_s, shot.begin_s + shot.exposure_s}, light_);
  if (vignetting_)
    pool_.for_rows(light_.rows(), [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) vignetting_->apply_row(light_, y);
    });
  if (flare_) flare_->apply(light_, pool_);
}

void SimulatedSensor::read_out(const Shot& shot, Image<std::uint16_t>& codes) {
  const int rows = light_.rows(), cols = light_.cols();
  codes.reshape(channels(layout_), rows, cols);
  electrons_.reshape(1, rows, cols);
  const float gain = static_cast<float>(shot.gain) / simulation_.full_well_e;
  pool_.for_rows(rows, [&](int y0, int y1) {
    // Of each row in turn.
    const std::span<float> charge(electrons_.row(0, y0), static_cast<std::size_t>(cols));
    for (int channel = 0; channel < codes.channels(); ++channel)
      for (int y = y0; y < y1; ++y) {
        read_row(shot, channel, y, charge);
        const auto code = [&](float e) { return quantiser_.code(e * gain); };
        const auto curved = [&](float e) { return quantiser_.code(response_->value(channel, e * gain)); };
        std::uint16_t* row = codes.row(channel, y);
        response_ ? std::transform(charge.begin(), charge.end(), row, curved)
                  : std::transform(charge.begin(), charge.end(), row, code);
      }
  });
}

// Reads the charge of one row.
void SimulatedSensor::read_row(const Shot& shot, int channel, int y, std::span<float> electrons) const {
  double per_light =
      shot.exposure_s * simulation_.sensitivity_per_s * static_cast<double>(simulation_.full_well_e);
  if (flicker_) {
    const auto& rolling = renderer_.shutter().rolling;
    per_light *= flicker_->factor(shot.begin_s + (rolling ? rolling->delay_s(y) : 0), shot.exposure_s);
  }
  if (mosaic_) {
    mosaic_->pick_row(light_, y, electrons);
    for (float& e : electrons) e *= static_cast<float>(per_light);
  } else {
    std::transform(light_.row(channel, y), light_.row(channel, y) + electrons.size(), electrons.begin(),
                   [&](float light) { return light * static_cast<float>(per_light); });
  }
  if (hot_pixels_) hot_pixels_->add(channel, y, static_cast<float>(shot.exposure_s), electrons);
  if (noise_) {
    const int row = channel * light_.rows() + y;
    noise_->apply(electrons, capacity_e(simulation_), shot.sequence,
                  static_cast<std::uint64_t>(row) * electrons.size());
  }
}

}  // namespace hdrcam
