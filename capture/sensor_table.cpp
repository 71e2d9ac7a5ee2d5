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
    {"imx219", {{2, 1, 2}, BlackLevel::of_code(64, 10)}},
    {"imx283", {{2, 1, 2}, BlackLevel::of_code(50, 10)}},
    {"imx290", {{2, 2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx296", {{2, 2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx462", {{2, 2, 2}, BlackLevel::of_code(60, 10)}},
    {"imx477", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"imx500", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"imx519", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"imx708", {{2, 2, 3}, BlackLevel::of_code(64, 10)}},
    {"ov5647", {{2, 2, 2}, BlackLevel::of_code(16, 10)}},
    {"ov7251", {{2, 2, 2}, BlackLevel::of_code(64, 10)}},
    {"ov9281", {{2, 2, 2}, BlackLevel::of_code(64, 10)}},
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
