#include "hal/sim/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include "hal/core/parse_number.h"
#include "hal/core/split_text.h"
#include "hal/sim/effects/delayed_control.h"

namespace hdrcam {
namespace {

Error invalid(std::string_view key, std::string_view value, std::string_view wanted) {
  return {ErrorCode::Invalid, fmt::format("simulation setting '{}={}': {}", key, value, wanted)};
}

// A number within [least, most].
template <class T>
Result<void> set_number(T& target, std::string_view key, std::string_view value, T least, T most) {
  const std::optional<T> number = parse_number<T>(value);
  if (!number || *number < least || *number > most)
    return invalid(key, value, fmt::format("give a number from {} to {}", least, most));
  target = *number;
  return {};
}

Result<void> set_size(Simulation& s, std::string_view key, std::string_view value) {
  const auto parts = split_list(value, 'x');
  if (parts.size() != 2) return invalid(key, value, "give width and height, for instance 320x240");
  TRY(set_number(s.width, key, parts[0], kLeastSimulated_px, kMostSimulated_px));
  return set_number(s.height, key, parts[1], kLeastSimulated_px, kMostSimulated_px);
}

Result<void> set_camera(Simulation& s, std::string_view key, std::string_view value) {
  const auto move = camera_move_of(value);
  if (!move) return invalid(key, value, "give still, handheld, pan, dolly or orbit");
  s.scene.camera = *move;
  return {};
}

Result<void> set_response(Simulation& s, std::string_view key, std::string_view value) {
  if (value == "linear")
    return s.plan.switch_off(Effect::Response, "asked for: response=linear"), Result<void>{};
  if (value != "gamma" && value != "film") return invalid(key, value, "give linear, gamma or film");
  s.response = value == "gamma" ? CurveShape::Gamma : CurveShape::Film;
  s.plan.switch_on(Effect::Response, fmt::format("asked for: response={}", value));
  return {};
}

// "2,1", or "2" for both
Result<void> set_delay(Simulation& s, std::string_view key, std::string_view value) {
  constexpr int kMost = DelayedControl<Duration>::kMost - 1;  // frames: one may be late by another
  const auto parts = split_list(value, ',');
  if (parts.empty() || parts.size() > 2)
    return invalid(key, value, "give frames for exposure and gain, for instance 2,1");
  TRY(set_number(s.control_delay.exposure, key, parts.front(), 0, kMost));
  TRY(set_number(s.control_delay.gain, key, parts.back(), 0, kMost));
  s.plan.switch_on(Effect::ControlDelay, fmt::format("asked for: delay={}", value));
  return {};
}

Result<void> set_drops(Simulation& s, std::string_view key, std::string_view value) {
  TRY(set_number(s.drops.probability, key, value, 0.0, 1.0));
  s.plan.switch_on(Effect::Drops, fmt::format("asked for: drops={}", value));
  return {};
}

Result<void> set_rays(Simulation& s, std::string_view key, std::string_view value) {
  if (value != "1" && value != "4") return invalid(key, value, "give 1 or 4");
  s.sampling = value == "1" ? Sampling::Quick : Sampling::Smooth;
  return {};
}

Result<void> set_reports(Simulation& s, std::string_view key, std::string_view value) {
  if (value != "yes" && value != "no") return invalid(key, value, "give yes or no");
  s.reports_exposure = value == "yes";
  return {};
}

enum class Wanted { With, Without };

Result<void> set_effects(Simulation& s, std::string_view key, std::string_view value, Wanted wanted) {
  const bool on = wanted == Wanted::With;
  for (const std::string_view name_text : split_list(value, ',')) {
    const auto effect = effect_of(name_text);
    if (!effect) return invalid(key, name_text, fmt::format("the effects are {}", effect_names()));
    if (*effect == Effect::Quantisation && !on) return invalid(key, name_text, "every sensor has it");
    if (*effect == Effect::Mosaic)
      return invalid(key, name_text,
                     fmt::format("the stream's format decides; ask for {} with --format",
                                 on ? "a Bayer format" : "an RGB format"));
    on ? s.plan.switch_on(*effect, fmt::format("asked for: with={}", name_text))
       : s.plan.switch_off(*effect, fmt::format("left out: without={}", name_text));
  }
  return {};
}

struct Setting {
  const char* key;
  const char* meaning;  // with unit and range
  Result<void> (*set)(Simulation&, std::string_view key, std::string_view value);
};
using Text = std::string_view;
constexpr Setting kSettings[] = {
    {"seed", "of scene and noise; 0..",
     [](Simulation& s, Text k, Text v) {
       return set_number(s.scene.seed, k, v, std::uint64_t{0}, std::uint64_t{1} << 53);
     }},
    {"size", "WIDTHxHEIGHT in pixels, 16..4096 each", set_size},
    {"fps", "frames per second, 1..1000",
     [](Simulation& s, Text k, Text v) { return set_number(s.framerate_hz, k, v, 1.0, 1000.0); }},
    {"view", "horizontal field of view, degrees, 10..90",
     [](Simulation& s, Text k, Text v) { return set_number(s.view_deg, k, v, 10.0, 90.0); }},
    {"objects", "boxes, balls and panels, 0..64",
     [](Simulation& s, Text k, Text v) { return set_number(s.scene.objects, k, v, 0, 64); }},
    {"lamps", "0..16", [](Simulation& s, Text k, Text v) { return set_number(s.scene.lamps, k, v, 0, 16); }},
    {"speed", "of all motion, 0..4",
     [](Simulation& s, Text k, Text v) { return set_number(s.scene.speed, k, v, 0.f, 4.f); }},
    {"pulse", "pulsating balls, relative size, 0..0.5",
     [](Simulation& s, Text k, Text v) { return set_number(s.scene.pulse, k, v, 0.f, 0.5f); }},
    {"camera", "still, handheld, pan, dolly or orbit", set_camera},
    {"full-well", "electrons at saturation, 100..100000",
     [](Simulation& s, Text k, Text v) { return set_number(s.full_well_e, k, v, 100.f, 1e5f); }},
    {"read-noise", "electrons rms, 0..100",
     [](Simulation& s, Text k, Text v) { return set_number(s.noise.read_noise_e, k, v, 0.f, 100.f); }},
    {"black", "black level, share of the code range, 0..0.2",
     [](Simulation& s, Text k, Text v) { return set_number(s.black_level, k, v, 0.f, 0.2f); }},
    {"response", "linear, gamma or film", set_response},
    {"delay", "exposure,gain control delay in frames, 0..6", set_delay},
    {"drops", "probability that a frame is lost, 0..1", set_drops},
    {"rays", "least rays per pixel: 4, or 1: faster, with jagged outlines", set_rays},
    {"reports", "yes or no: buffers report their exposure, and the camera its raw black level", set_reports},
    {"with", "effects to add, separated by commas",
     [](Simulation& s, Text k, Text v) { return set_effects(s, k, v, Wanted::With); }},
    {"without", "effects to leave out",
     [](Simulation& s, Text k, Text v) { return set_effects(s, k, v, Wanted::Without); }},
};

std::string scene_names() {
  std::string names;
  for (const CatalogScene& scene : scene_catalog())
    names += (names.empty() ? "" : ", ") + std::string(scene.name);
  return names;
}

std::string setting_names() {
  std::string names;
  for (const Setting& setting : kSettings) names += (names.empty() ? "" : ", ") + std::string(setting.key);
  return names;
}

struct GivenSetting {
  std::string_view key, value;
};

// Each setting once, lists of effects apart; and no effect both with and without.
Result<void> check_given(std::span<const GivenSetting> given) {
  std::vector<std::string_view> added, left_out;
  for (const GivenSetting& one : given)
    if (one.key == "with" || one.key == "without") {
      auto& effects = one.key == "with" ? added : left_out;
      std::ranges::copy(split_list(one.value, ','), std::back_inserter(effects));
    } else if (std::ranges::count(given, one.key, &GivenSetting::key) > 1) {
      return Error{ErrorCode::Invalid,
                   fmt::format("simulation setting '{}' is given more than once; give it once", one.key)};
    }
  for (const std::string_view effect : added)
    if (std::ranges::find(left_out, effect) != left_out.end())
      return invalid("with", effect, "it is left out as well; take it out of with or of without");
  return {};
}

}  // namespace

Result<Simulation> simulation_of(std::string_view text) {
  const std::size_t question = std::min(text.find('?'), text.size());
  const std::string_view scene = text.substr(0, question);
  const auto catalog = scene_catalog();
  const auto entry =
      std::find_if(catalog.begin(), catalog.end(), [&](const auto& each) { return scene == each.name; });
  if (entry == catalog.end())
    return Error{ErrorCode::NotFound,
                 fmt::format("there is no scene '{}'; the scenes are {}", scene, scene_names())};
  Simulation simulation;
  simulation.scene = entry->settings;
  simulation.full_well_e = entry->full_well_e;
  for (const auto& need : entry->needs) simulation.plan.switch_on(need.effect, need.why);
  std::vector<GivenSetting> given;
  for (const std::string_view pair : split_list(text.substr(std::min(question + 1, text.size())), '&')) {
    const std::size_t equals = std::min(pair.find('='), pair.size());
    const std::string_view key = pair.substr(0, equals),
                           value = pair.substr(std::min(equals + 1, pair.size()));
    const auto setting =
        std::find_if(std::begin(kSettings), std::end(kSettings), [&](const auto& s) { return key == s.key; });
    if (setting == std::end(kSettings))
      return Error{ErrorCode::Invalid, fmt::format("there is no simulation setting '{}'; the settings are {}",
                                                   key, setting_names())};
    TRY(setting->set(simulation, key, value));
    given.push_back({key, value});
  }
  TRY(check_given(given));
  return simulation;
}

std::string simulation_settings_help() {
  std::string text;
  for (const Setting& setting : kSettings) text += fmt::format("  {:<11}{}\n", setting.key, setting.meaning);
  return text;
}

}  // namespace hdrcam
