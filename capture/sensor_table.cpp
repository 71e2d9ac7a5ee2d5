#include "capture/sensor_table.h"

#include <algorithm>
#include <iterator>

namespace hdrcam {
namespace {

struct SensorRow {
  std::string_view name;
  KnownSensor sensor;
};

constexpr SensorRow kSensors[] = {
    {"imx219", {ControlDelays{2, 1}, BlackLevel::of_code(64, 10)}},
    {"imx283", {ControlDelays{2, 1}, BlackLevel::of_code(50, 10)}},
    {"imx290", {ControlDelays{2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx296", {ControlDelays{2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx462", {ControlDelays{2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx477", {ControlDelays{2, 2}, BlackLevel::of_code(64, 10)}},
    {"imx500", {ControlDelays{2, 2}, BlackLevel::of_code(64, 10)}},
    {"imx519", {ControlDelays{2, 2}, BlackLevel::of_code(64, 10)}},
    {"imx708", {ControlDelays{2, 2}, BlackLevel::of_code(64, 10)}},
    {"ov5647", {ControlDelays{2, 2}, BlackLevel::of_code(16, 10)}},
    {"ov7251", {ControlDelays{2, 2}, BlackLevel::of_code(64, 10)}},
    {"ov9281", {ControlDelays{2, 2}, BlackLevel::of_code(64, 10)}},
};

}  // namespace

std::optional<KnownSensor> known_sensor(std::string_view model) {
  const auto row = std::find_if(std::begin(kSensors), std::end(kSensors), [&](const SensorRow& r) {
    return model.find(r.name) != std::string_view::npos;
  });
  if (row == std::end(kSensors)) return std::nullopt;
  return row->sensor;
}

}  // namespace hdrcam
