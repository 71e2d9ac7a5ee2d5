#include "hal/real/known_sensors.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hdrcam {
namespace {

using Law = GainCodes::Law;

struct Known {
  std::string_view sensor;
  GainCodes gain;
  Shutter shutter = Shutter::Rolling;
};
constexpr Known kKnown[] = {
    {"imx219", {Law::Reciprocal, 256}},
    {"imx258", {Law::Reciprocal, 512}},
    {"imx283", {Law::Reciprocal, 2048}},
    {"imx477", {Law::Reciprocal, 1024}},
    {"imx500", {Law::Reciprocal, 1024}},
    {"imx519", {Law::Reciprocal, 1024}},
    {"imx708", {Law::Reciprocal, 1024}},
    {"imx290", {Law::Decibel, 0.3}},
    {"imx296", {Law::Decibel, 0.1}, Shutter::Global},
    {"imx327", {Law::Decibel, 0.3}},
    {"imx335", {Law::Decibel, 0.3}},
    {"imx415", {Law::Decibel, 0.3}},
    {"imx462", {Law::Decibel, 0.3}},
    {"ov2740", {Law::Proportional, 128}},
    {"ov4689", {Law::Proportional, 128}},
    {"ov5640", {Law::Proportional, 16}},
    {"ov5647", {Law::Proportional, 16}},
    {"ov5670", {Law::Proportional, 128}},
    {"ov5675", {Law::Proportional, 128}},
    {"ov5693", {Law::Proportional, 16}},
    {"ov7251", {Law::Proportional, 16}, Shutter::Global},
    {"ov8865", {Law::Proportional, 128}},
    {"ov9281", {Law::Proportional, 16}, Shutter::Global},
    {"ov9282", {Law::Proportional, 16}, Shutter::Global},
    {"ov13858", {Law::Proportional, 128}},
};

const Known* known(std::string_view sensor) {
  const auto* const found =
      std::ranges::find_if(kKnown, [&](const Known& one) { return sensor.starts_with(one.sensor); });
  return found == std::end(kKnown) ? nullptr : found;
}

}  // namespace

double GainCodes::gain_of(double code) const {
  switch (law) {
    case Law::Reciprocal:
      return scale / (scale - code);
    case Law::Decibel:
      return std::pow(10, code * scale / 20);
    case Law::Proportional:
      break;
  }
  return code / scale;
}

double GainCodes::code_of(double gain) const {
  switch (law) {
    case Law::Reciprocal:
      return scale - scale / gain;
    case Law::Decibel:
      return 20 * std::log10(gain) / scale;
    case Law::Proportional:
      break;
  }
  return gain * scale;
}

std::optional<GainCodes> gain_codes_of(std::string_view sensor, double lowest_code) {
  if (const Known* const one = known(sensor)) return one->gain;
  return lowest_code > 0 ? std::optional(GainCodes{Law::Proportional, lowest_code}) : std::nullopt;
}

Shutter shutter_of(std::string_view sensor) {
  const Known* const one = known(sensor);
  return one != nullptr ? one->shutter : Shutter::Unknown;
}

}  // namespace hdrcam
