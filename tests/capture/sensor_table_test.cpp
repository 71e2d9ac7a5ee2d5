#include "capture/sensor_table.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("sensors are known by their name in whatever the driver calls the camera", "[capture]") {
  const auto imx219 = known_sensor("/base/soc/i2c0mux/i2c@1/imx219@10");
  REQUIRE(imx219);
  CHECK((imx219->delays.exposure == 2 && imx219->delays.gain == 1 && imx219->delays.vblank == 2));
  CHECK(imx219->black_level.code(10) == 64);
  CHECK(known_sensor("imx477")->delays.most() == 3);
  CHECK(known_sensor("ov5647")->delays.gain == 2);
  CHECK_FALSE(known_sensor("HD Webcam C270"));
}

}  // namespace
}  // namespace hdrcam
