#include "capture/sensor_table.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("sensors are known by their name in whatever the driver calls the camera", "[capture]") {
  const auto imx219 = known_sensor("/base/soc/i2c0mux/i2c@1/imx219@10");
  REQUIRE(imx219);
  CHECK(imx219->delays == ControlDelays{2, 1});
  CHECK(imx219->black_level.code(10) == 64);
  CHECK(known_sensor("imx477")->delays == ControlDelays{2, 2});
  CHECK(known_sensor("ov5647")->delays.gain == 2);
  CHECK_FALSE(known_sensor("HD Webcam C270"));
}

}  // namespace
}  // namespace hdrcam
