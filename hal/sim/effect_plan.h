// Which effects a simulation has, and why. A scene names the effects that it needs; the stream's format
// decides some; a user adds or leaves out others. An effect that is off is not constructed, so it costs
// nothing. Value type, reentrant.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace hdrcam {

// In the order in which light, then charge, then the stream meets them.
enum class Effect {
  MotionBlur,
  RollingShutter,
  Distortion,
  Vignetting,
  Flare,
  MainsFlicker,  // light
  Mosaic,
  HotPixels,
  Noise,
  Quantisation,
  Response,  // sensor
  ControlDelay,
  Drops,
  ClockJitter,  // stream
};
constexpr std::size_t kEffects = static_cast<std::size_t>(Effect::ClockJitter) + 1;

const char* name(Effect effect);  // "motion-blur"
std::optional<Effect> effect_of(std::string_view name);
std::string effect_names();  // all of them, for messages

class EffectPlan {
 public:
  EffectPlan();  // only the effects that every sensor has

  void switch_on(Effect effect, std::string why) { entry(effect) = {true, std::move(why)}; }
  void switch_off(Effect effect, std::string why) { entry(effect) = {false, std::move(why)}; }
  bool on(Effect effect) const { return entries_[static_cast<std::size_t>(effect)].on; }
  const std::string& why(Effect effect) const { return entries_[static_cast<std::size_t>(effect)].why; }

 private:
  struct Entry {
    bool on = false;
    std::string why;
  };
  Entry& entry(Effect effect) { return entries_[static_cast<std::size_t>(effect)]; }

  std::array<Entry, kEffects> entries_;
};

}  // namespace hdrcam
