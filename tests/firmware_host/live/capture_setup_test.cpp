// Which mode of a camera follows from the settings.
#include "firmware_host/live/capture_setup.h"

#include <tuple>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

// Raw in two sizes, YUYV in three, MJPEG in one that no other format has.
CameraCapabilities camera_of_many_modes() {
  CameraCapabilities camera;
  camera.id = "/dev/video5";
  using enum PixelFormat;
  for (const auto& [format, width, height] : {std::tuple{Yuyv, 320, 240},
                                              {Yuyv, 640, 480},
                                              {Yuyv, 800, 600},
                                              {Rggb10, 656, 492},
                                              {Rggb10, 1640, 1232},
                                              {Rggb8, 800, 600},
                                              {Mjpeg, 1920, 1080}})
    camera.modes.push_back({.format = format, .width = width, .height = height});
  return camera;
}

// Like "YUYV 640x480".
std::string mode_of(int width, int height, const std::string& format = "") {
  Settings::Camera wanted;
  wanted.width = width, wanted.height = height, wanted.format = format;
  const StreamMode mode = value_of(mode_for(wanted, camera_of_many_modes()));
  return fmt::format("{} {}x{}", name(mode.format), mode.width, mode.height);
}

TEST_CASE("a size that is set is taken in the best format that has it") {
  CHECK(mode_of(640, 480) == "YUYV 640x480");
  CHECK(mode_of(800, 600) == "RGGB8 800x600");
  CHECK(mode_of(1640, 1232) == "RGGB10 1640x1232");
  CHECK(mode_of(1920, 1080) == "MJPEG 1920x1080");
  CHECK(mode_of(320, 0) == "YUYV 320x240");
  CHECK(mode_of(0, 1080) == "MJPEG 1920x1080");
}

TEST_CASE("the best format is taken where no size is set, or none of the formats has it") {
  CHECK(mode_of(0, 0) == "RGGB10 656x492");
  CHECK(mode_of(1000, 700) == "RGGB10 1000x700");  // the camera then takes the nearest
}

TEST_CASE("of a mono sensor the most bits are taken, but of a camera that has colour the colour") {
  using enum PixelFormat;
  const auto taken_of = [](std::initializer_list<PixelFormat> formats) {
    CameraCapabilities camera;
    for (const PixelFormat format : formats)
      camera.modes.push_back({.format = format, .width = 640, .height = 400});
    return std::string(name(value_of(mode_for({}, camera)).format));
  };
  CHECK(taken_of({Grey8, Grey10Packed, Grey10}) == "GREY10");
  CHECK(taken_of({Grey8, Grey10Packed}) == "GREY10P");
  CHECK(taken_of({Grey12, Mjpeg, Grey8}) == "MJPEG");
  CHECK(taken_of({Grey12, Nv12, Bggr10, Rgb24}) == "BGGR10");
  CHECK(taken_of({Mjpeg, Nv12, Uyvy}) == "UYVY");
}

TEST_CASE("a format that is set is taken, whatever the size") {
  CHECK(mode_of(1920, 1080, "YUYV") == "YUYV 1920x1080");
  CHECK(mode_of(640, 480, "RGGB8") == "RGGB8 640x480");
}

TEST_CASE("a format that a camera does not have is refused with the modes that it has") {
  Settings::Camera wanted;
  wanted.format = "NV12";
  const auto refused = mode_for(wanted, camera_of_many_modes());
  require_error(refused, ErrorCode::Unsupported);
  CHECK(refused.error().message ==
        "'/dev/video5' has no format 'NV12'; it offers YUYV 320x240, YUYV 640x480, YUYV 800x600, RGGB10 "
        "656x492, "
        "RGGB10 1640x1232, RGGB8 800x600, MJPEG 1920x1080");
}

TEST_CASE("the sizes of a format are those that the camera lists, where it lists several") {
  const auto sizes_where = [](PixelFormat format, int width, int height) {
    return sizes_of(camera_of_many_modes(), {.format = format, .width = width, .height = height});
  };
  CHECK(sizes_where(PixelFormat::Yuyv, 640, 480) == "320x240, 640x480, 800x600");
  CHECK(sizes_where(PixelFormat::Mjpeg, 1920, 1080).empty());
  CHECK(sizes_where(PixelFormat::Yuyv, 700, 500).empty());  // it scales
}

}  // namespace
}  // namespace hdrcam
