// What a sensor behind a receiver answers, by the test.
#include "hal/real/sensor_path.h"

#include <linux/v4l2-subdev.h>

#include <array>
#include <cerrno>

#include "hal/real/v4l2_formats.h"
#include "tests/contracts/expect.h"
#include "tests/support/answered_ioctl.h"

namespace hdrcam {
namespace {

struct SizeOfSensor {
  std::uint32_t width, height;
};
constexpr std::array<SizeOfSensor, 2> kSizes{{{3280, 2464}, {1640, 1232}}};

// Sends 10 bits in two sizes, and takes the second where it cannot send what it is asked for.
int answer_of_sensor(unsigned long request, void* argument) {
  if (request == VIDIOC_SUBDEV_ENUM_FRAME_SIZE) {
    auto& size = *static_cast<v4l2_subdev_frame_size_enum*>(argument);
    if (size.pad != 0 || size.code != bus_code_of(PixelFormat::Rggb10) || size.index >= kSizes.size())
      return EINVAL;
    size.min_width = size.max_width = kSizes[size.index].width;
    size.min_height = size.max_height = kSizes[size.index].height;
    return 0;
  }
  if (request != VIDIOC_SUBDEV_S_FMT) return ENOTTY;
  auto& picture = *static_cast<v4l2_subdev_format*>(argument);
  if (picture.pad == 0 && picture.format.width != kSizes[0].width)
    picture.format.width = kSizes[1].width, picture.format.height = kSizes[1].height;
  return 0;
}

std::string text_of(const std::vector<StreamMode>& modes) {
  std::string text;
  for (const StreamMode& mode : modes)
    text += fmt::format("{}{} {}x{}", text.empty() ? "" : ", ", name(mode.format), mode.width, mode.height);
  return text;
}

// A receiver that takes any size from any sensor.
std::vector<StreamMode> modes_of_receiver() {
  std::vector<StreamMode> modes;
  for (const PixelFormat format :
       {PixelFormat::Nv12, PixelFormat::Rggb12, PixelFormat::Rggb10, PixelFormat::Rggb10Packed})
    modes.push_back({.format = format, .width = 16384, .height = 16384});
  return modes;
}

TEST_CASE("the raw modes of a receiver that takes all are those that its sensor sends") {
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  const test::AnsweredIoctl kernel(answer_of_sensor);
  CHECK(text_of(modes_of_sensor(sensor, 0, modes_of_receiver())) ==
        "NV12 16384x16384, RGGB10 3280x2464, RGGB10 1640x1232, RGGB10P 3280x2464, RGGB10P 1640x1232");
}

TEST_CASE("a sensor that sends any size of a range offers the usual one and its largest") {
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  const test::AnsweredIoctl kernel([](unsigned long request, void* argument) {
    if (request != VIDIOC_SUBDEV_ENUM_FRAME_SIZE) return ENOTTY;
    auto& size = *static_cast<v4l2_subdev_frame_size_enum*>(argument);
    if (size.code != bus_code_of(PixelFormat::Rggb12) || size.index > 0) return EINVAL;
    size.min_width = 16, size.max_width = 2592, size.min_height = 16, size.max_height = 1944;
    return 0;
  });
  CHECK(text_of(modes_of_sensor(sensor, 0, modes_of_receiver())) ==
        "NV12 16384x16384, RGGB12 640x480, RGGB12 2592x1944");
}

TEST_CASE("the modes of a receiver stay where its sensor lists no size") {
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  const test::AnsweredIoctl kernel([](unsigned long, void*) { return ENOTTY; });
  CHECK(text_of(modes_of_sensor(sensor, 0, modes_of_receiver())) == text_of(modes_of_receiver()));
}

TEST_CASE("every pad behind a sensor gets the size that the sensor took") {
  std::vector<std::uint32_t> widths;
  const test::AnsweredIoctl kernel([&](unsigned long request, void* argument) {
    const int code = answer_of_sensor(request, argument);
    widths.push_back(static_cast<v4l2_subdev_format*>(argument)->format.width);
    return code;
  });
  const std::vector<SubdevicePad> path{{"/dev/null", 0}, {"/dev/null", 1}, {"/dev/null", 2}};
  const StreamMode mode =
      value_of(set_format_along(path, {.format = PixelFormat::Rggb10, .width = 1000, .height = 700}));
  CHECK(mode.width == 1640);
  CHECK(mode.height == 1232);
  CHECK(widths == std::vector<std::uint32_t>{1640, 1640, 1640});
  const StreamMode has =
      value_of(set_format_along(path, {.format = PixelFormat::Rggb10, .width = 3280, .height = 2464}));
  CHECK(has.width == 3280);
}

TEST_CASE("a sensor whose receiver sets its format, so that its node is read-only, is left to the receiver") {
  int asked = 0;
  const test::AnsweredIoctl kernel([&](unsigned long, void*) { return ++asked, EPERM; });
  const std::vector<SubdevicePad> path{{"/dev/null", 0}, {"/dev/null", 1}};
  const StreamMode mode =
      value_of(set_format_along(path, {.format = PixelFormat::Rggb10, .width = 1000, .height = 700}));
  CHECK(asked == 1);
  CHECK(mode.width == 1000);
  CHECK(mode.height == 700);
}

TEST_CASE("a sensor that does not take a format is told of, with its node") {
  const test::AnsweredIoctl kernel([](unsigned long, void*) { return EBUSY; });
  const auto refused = set_format_along({{"/dev/null", 0}}, {.format = PixelFormat::Rggb10, .width = 1000});
  require_error(refused, ErrorCode::Busy);
  CHECK_THAT(refused.error().message, Catch::StartsWith("'/dev/null' is in use by"));
}

}  // namespace
}  // namespace hdrcam
