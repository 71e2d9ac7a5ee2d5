#include "hal/sim/effect_plan.h"

namespace hdrcam {

const char* name(Effect effect) {
  switch (effect) {
    case Effect::MotionBlur:
      return "motion-blur";
    case Effect::RollingShutter:
      return "rolling-shutter";
    case Effect::Distortion:
      return "distortion";
    case Effect::Vignetting:
      return "vignetting";
    case Effect::Flare:
      return "flare";
    case Effect::MainsFlicker:
      return "mains-flicker";
    case Effect::Mosaic:
      return "mosaic";
    case Effect::HotPixels:
      return "hot-pixels";
    case Effect::Noise:
      return "noise";
    case Effect::Quantisation:
      return "quantisation";
    case Effect::Response:
      return "response";
    case Effect::ControlDelay:
      return "control-delay";
    case Effect::Drops:
      return "drops";
    case Effect::ClockJitter:
      return "clock-jitter";
  }
  return "?";
}

std::optional<Effect> effect_of(std::string_view wanted) {
  for (std::size_t i = 0; i < kEffects; ++i)
    if (wanted == name(static_cast<Effect>(i))) return static_cast<Effect>(i);
  return std::nullopt;
}

std::string effect_names() {
  std::string names = name(Effect{});
  for (std::size_t i = 1; i < kEffects; ++i) names += std::string(", ") + name(static_cast<Effect>(i));
  return names;
}

EffectPlan::EffectPlan() {
  for (Entry& each : entries_) each.why = "the scene does not need it";
  switch_on(Effect::Quantisation, "codes are whole numbers of limited range");
}

}  // namespace hdrcam
