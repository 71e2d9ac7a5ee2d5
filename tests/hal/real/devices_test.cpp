// What can be known of real devices on a machine that has none: sentences for what is missing, and the
// arithmetic.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <utility>

#include "hal/real/camera_libcamera.h"
#include "hal/real/camera_v4l2.h"
#include "hal/real/control_pacer.h"
#include "hal/real/device_node.h"
#include "hal/real/enumerate.h"
#include "hal/real/known_sensors.h"
#include "hal/real/libcamera_error.h"
#include "hal/real/sync_line_gpiod.h"
#include "hal/real/v4l2_formats.h"
#include "tests/contracts/expect.h"
#include "tests/support/becomes_true.h"
#include "tests/support/not_tested.h"
#include "tests/support/scratch_folder.h"

#include "tests/support/as_nobody.h"

namespace hdrcam {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

template <class T>
void require_sentence(const Result<T>& result, ErrorCode code, const std::string& part) {
  require_error(result, code);
  INFO(result.error().message);
  CHECK(result.error().message.find(part) != std::string::npos);
}

TEST_CASE("a camera node that is not there is named") {
  require_sentence(open_v4l2_camera("/dev/video77"), ErrorCode::NotFound, "'/dev/video77'");
  require_sentence(open_real_camera("/dev/video77"), ErrorCode::NotFound, "'/dev/video77'");
}

TEST_CASE("nodes are found by the beginning of their name, numbers in their order") {
  CHECK(device_nodes("nothing-begins-so").empty());
  CHECK(device_nodes("nul") == std::vector<std::string>{"/dev/null"});
  const auto nodes = device_nodes("");
  CHECK(std::ranges::is_sorted(nodes, {}, &std::string::size));
  CHECK(std::ranges::count(nodes, "/dev/null") == 1);
}

TEST_CASE("a node that is no camera is refused as unsupported") {
  require_sentence(open_v4l2_camera("/dev/null"), ErrorCode::Unsupported, "'/dev/null'");
}

TEST_CASE("a camera that libcamera does not know is named") {
  const auto opened = open_libcamera_camera("no such camera");
  REQUIRE_FALSE(opened.ok());
  if (opened.error().code == ErrorCode::Unsupported)
    CHECK(opened.error().message.find("libcamera-dev") != std::string::npos);
  else
    require_sentence(opened, ErrorCode::NotFound, "'no such camera'");
}

TEST_CASE("without any camera the sentence says so and what to do") {
  for (const FoundDevice& device : list_devices())
    if (device.kind == DeviceKind::Camera && !device.id.empty()) {
      NOT_TESTED("this machine has a camera");
      return;
    }
  require_sentence(open_real_camera(""), ErrorCode::NotFound, "there is no camera");
  require_sentence(open_real_camera("imx219"), ErrorCode::NotFound, "'imx219'");
}

TEST_CASE("a GPIO line that is not there is named") {
  const auto opened = open_gpio_line({.line = "gpiochip77:3"});
  REQUIRE_FALSE(opened.ok());
  if (opened.error().code != ErrorCode::Unsupported)
    require_sentence(opened, ErrorCode::NotFound, "'gpiochip77:3'");
}

TEST_CASE("GPIO lines are named by chip and number or by their own name") {
  const auto parsed = parse_line_name("gpiochip4:17");
  REQUIRE(parsed.has_value());
  CHECK(parsed->chip == "gpiochip4");
  CHECK(parsed->offset == 17);
  for (const char* name :
       {"STROBE", "gpiochip4", "gpiochip4:", "gpiochip4:x", "gpiochip4:1x", "gpiochip4:-1"})
    CHECK_FALSE(parse_line_name(name).has_value());
}

TEST_CASE("a GPIO line is one line, with however many zeros its number is written") {
  CHECK(same_gpio_line("gpiochip0:17", "gpiochip0:017"));
  CHECK_FALSE(same_gpio_line("gpiochip0:17", "gpiochip1:17"));
  CHECK_FALSE(same_gpio_line("gpiochip0:17", "gpiochip0:170"));
}

TEST_CASE("a GPIO line that cannot be used as it is asked to says which kind to choose") {
  for (const int code : {EINVAL, ENXIO, ENOTSUP}) {
    const Error error = line_error(code, "gpiochip1:3", "");
    CHECK(error.code == ErrorCode::Unsupported);
    CHECK_THAT(error.message, Catch::StartsWith("GPIO line 'gpiochip1:3' cannot do this: ") &&
                                  Catch::Contains("choose one that has interrupts"));
  }
}

TEST_CASE("a GPIO line whose state cannot be read leaves those behind it their numbers") {
  const auto lines = lines_by_number(3, [](unsigned i) -> std::optional<GpioLineState> {
    if (i == 1) return std::nullopt;
    return GpioLineState{.name = fmt::format("LINE{}", i)};
  });
  REQUIRE(lines.size() == 3);
  CHECK(lines[1].name.empty());
  CHECK(lines[2].name == "LINE2");
  CHECK(describe(lines[1], "gpiochip0", 1) == "gpiochip0:1 unnamed, its state cannot be read");  // not free
}

TEST_CASE(
    "a GPIO line is listed unless it is unnamed and free, also one that is held by nobody who is named") {
  CHECK(describe({}, "gpiochip0", 3).empty());
  CHECK(describe({.name = "STROBE"}, "gpiochip0", 3) == "gpiochip0:3 STROBE");
  CHECK(describe({.name = "LED", .use = GpioLineUse::Held, .consumer = "led", .output = true}, "gpiochip0",
                 17) == "gpiochip0:17 LED, output, held by 'led'");
  CHECK(describe({.use = GpioLineUse::Held}, "gpiochip0", 4) == "gpiochip0:4 unnamed, held");
}

TEST_CASE("every errno of a device becomes a code and a sentence with its name") {
  const std::pair<int, ErrorCode> kinds[] = {
      {ENOENT, ErrorCode::NotFound},    {EACCES, ErrorCode::Permission},
      {EBUSY, ErrorCode::Busy},         {ENODEV, ErrorCode::Unplugged},
      {EINVAL, ErrorCode::Unsupported}, {EPIPE, ErrorCode::Invalid},
      {ENOSPC, ErrorCode::Io},          {EIO, ErrorCode::Io}};
  for (const auto& [code, kind] : kinds) {
    const Error error = device_error(code, "/dev/video5", "start its stream");
    INFO(error.message);
    CHECK(static_cast<int>(error.code) == static_cast<int>(kind));
    CHECK(error.message.find("/dev/video5") != std::string::npos);
    CHECK(error.sys_errno == code);
  }
}

TEST_CASE("a USB bus that has no room for a stream is not told of as a full disk") {
  const Error error = device_error(ENOSPC, "/dev/video5", "start its stream");
  CHECK_THAT(error.message, Catch::StartsWith("'/dev/video5' cannot start its stream: the USB bus has no "
                                              "bandwidth left for it; choose a smaller size"));
  const Error by_libcamera = libcamera_error(-ENOSPC, "usb-1", "start its stream");
  CHECK_THAT(by_libcamera.message,
             Catch::StartsWith("camera 'usb-1' cannot start its stream: the USB bus has no bandwidth left"));
}

// A USB cable or the ribbon of a sensor's board, which is damaged where it is plugged with power on it.
TEST_CASE("a device whose bus fails says what to check, whichever driver tells it") {
  const char* const advice =
      "check its cable and hub; plug a USB camera in again, a ribbon cable only with the power off";
  for (const int code : {EIO, EPROTO, EREMOTEIO, ETIMEDOUT}) {
    CHECK_THAT(device_error(code, "/dev/video5", "deliver a frame").message, Catch::EndsWith(advice));
    CHECK_THAT(libcamera_error(-code, "usb-1", "start its stream").message, Catch::EndsWith(advice));
  }
  CHECK_THAT(device_error(ENOMEM, "/dev/video5", "map its buffers").message, !Catch::Contains(advice));
}

TEST_CASE("who holds a busy device is another program, or unknown, and never this one") {
  const std::string node =
      std::filesystem::canonical(test::scratch_folder("busy_device")).string() + "/video0";
  std::ofstream(node) << "held";
  const DeviceNode ours = value_of(DeviceNode::open(node));
  CHECK(holder_of(node).empty());
  CHECK_THAT(device_error(EBUSY, node, "stream").message, Catch::Contains("is in use by another program"));
  std::FILE* const other = ::popen(fmt::format("exec cat 3<'{}'", node).c_str(), "w");
  REQUIRE(other != nullptr);
  std::string holder;
  // until then it is the shell that starts it
  CHECK(test::becomes_true([&] { return (holder = holder_of(node)).starts_with("'cat'"); }));
  std::filesystem::create_symlink(node, node + "-by-id");
  CHECK(holder_of(node + "-by-id") == holder);
  ::pclose(other);
  CHECK_THAT(holder,
             Catch::Contains("(process ") && !Catch::Contains(fmt::format("(process {})", ::getpid())));
}

TEST_CASE("of some nodes the first that this user may not open is named, with how to get permission") {
  const std::string folder = test::scratch_folder("closed_nodes"), open = folder + "/video0",
                    closed = folder + "/video1";
  for (const std::string& node : {open, closed}) std::ofstream(node) << "a node";
  std::filesystem::permissions(open, std::filesystem::perms(0666));
  std::filesystem::permissions(closed, std::filesystem::perms::none);
  const test::AsNobody nobody;
  CHECK_FALSE(closed_node({}).has_value());
  CHECK_FALSE(closed_node({open, folder + "/video2"}).has_value());
  const auto found = closed_node({open, closed});
  REQUIRE(found.has_value());
  CHECK(found->code == ErrorCode::Permission);
  CHECK_THAT(found->message, Catch::StartsWith(fmt::format("no permission for '{}': ", closed)));
}

TEST_CASE("a control that a device in use refuses is told as that, and never as a full queue") {
  for (const int code : {EBUSY, EPIPE, EACCES, EIO, ERANGE}) {
    const Error error = control_error(code, "/dev/video5", "set its exposure");
    CHECK(error.code == ErrorCode::Io);
    CHECK(error.sys_errno == code);
    CHECK_THAT(error.message, Catch::StartsWith("'/dev/video5' refused to set its exposure: "));
  }
  CHECK(control_error(ENODEV, "/dev/video5", "set its exposure").code == ErrorCode::Unplugged);
  CHECK(control_error(EINVAL, "/dev/video5", "set its exposure").code == ErrorCode::Unsupported);
}

TEST_CASE("every pixel format has a code of its own that leads back to it") {
  std::set<std::uint32_t> codes;
  for (int i = 0; i <= static_cast<int>(PixelFormat::Bggr12Packed); ++i) {
    const auto format = static_cast<PixelFormat>(i);
    INFO(name(format) << " is " << fourcc_text(fourcc_of(format)));
    CHECK(codes.insert(fourcc_of(format)).second);
    CHECK(format_of(fourcc_of(format)) == format);
  }
  CHECK_FALSE(format_of(0x34363248).has_value());  // H264
}

TEST_CASE("the gain codes of known sensors are those of their data sheets") {
  CHECK(gain_codes_of("imx219 10-0010", 0)->gain_of(232) == Approx(256. / 24));
  CHECK(gain_codes_of("imx477 10-001a", 0)->gain_of(978) == Approx(1024. / 46));
  CHECK(gain_codes_of("imx290 1-001a", 0)->gain_of(100) == Approx(31.6228).epsilon(1e-4));  // 30 dB
  CHECK(gain_codes_of("ov5647 10-0036", 16)->gain_of(64) == Approx(4));
  CHECK(gain_codes_of("some sensor", 32)->gain_of(64) == Approx(2));
  CHECK_FALSE(gain_codes_of("some sensor", 0).has_value());  // which code doubles the light?
  for (const char* sensor : {"imx219", "imx296", "ov9281", "imx708", "another"})
    for (const double gain : {1., 1.5, 2., 8.}) {
      const GainCodes codes = gain_codes_of(sensor, 16).value();
      INFO(sensor << " at gain " << gain);
      CHECK(codes.gain_of(codes.code_of(gain)) == Approx(gain));
    }
}

TEST_CASE("rows of known sensors are exposed one after the other, or all at once") {
  CHECK(shutter_of("imx219 10-0010") == Shutter::Rolling);
  for (const char* sensor : {"imx296 10-001a", "ov7251 1-0060", "ov9281 1-0060", "ov9282"})
    CHECK(shutter_of(sensor) == Shutter::Global);
  CHECK(shutter_of("some sensor") == Shutter::Unknown);
}

// A camera of 30 frames a second whose controls are written 20 ms after each frame's timestamp.
struct PacedStream {
  ControlPacer pacer;
  Instant frame_begin{milliseconds(1000)};

  explicit PacedStream(std::uint64_t requests) {
    for (std::uint64_t k = 0; k < requests; ++k) pacer.queued({.cookie = k});
  }
  void write(milliseconds after_timestamp = milliseconds(20)) {
    const auto due = pacer.due();
    REQUIRE(due.has_value());
    pacer.written(*due, frame_begin + after_timestamp);
  }
  // Whether the frame's own control was late.
  bool complete() {
    frame_begin = frame_begin + milliseconds(33);
    return pacer.completed(frame_begin);
  }
};

TEST_CASE("paced controls are written once per frame, that of the next frame") {
  PacedStream stream(8);
  CHECK_FALSE(ControlPacer().due().has_value());
  for (std::uint64_t frame = 0; frame < 8; ++frame) {
    CHECK(stream.pacer.due()->request.cookie == frame);
    stream.write();
    CHECK_FALSE(stream.pacer.due().has_value());
    CHECK_FALSE(stream.complete());
  }
  CHECK_FALSE(stream.pacer.due().has_value());  // the queue ran dry
  stream.pacer.queued({.cookie = 8});
  CHECK(stream.pacer.due()->request.cookie == 8);
}

TEST_CASE("a paced control that was missed is not written any more, and its frame says so") {
  PacedStream stream(8);
  stream.write();
  CHECK_FALSE(stream.complete());
  CHECK(stream.complete());
  CHECK(stream.complete());
  CHECK(stream.pacer.due()->request.cookie == 3);
}

TEST_CASE("a paced control that was given up is not due again, and its frame says so") {
  PacedStream stream(8);
  stream.write();
  CHECK_FALSE(stream.complete());
  stream.pacer.given_up(*stream.pacer.due());
  CHECK_FALSE(stream.pacer.due().has_value());
  CHECK(stream.complete());
  stream.write();
  CHECK_FALSE(stream.complete());
}

TEST_CASE("a paced control whose write failed after all is late, and no other") {
  PacedStream stream(8);
  for (std::uint64_t frame = 0; frame < 8; ++frame) {
    const auto turn = *stream.pacer.due();
    stream.write();
    if (frame == 3) stream.pacer.given_up(turn);
    CHECK(stream.complete() == (frame == 3));
    stream.pacer.given_up(turn);  // its frame is complete
  }
}

TEST_CASE("a paced control that is written late says so, and only that one") {
  PacedStream stream(64);
  for (int frame = 0; frame < 60; ++frame) {
    const bool late = frame == 20 || frame == 40;
    stream.write(milliseconds(late ? 32 : 18 + frame % 3));
    INFO("frame " << frame);
    REQUIRE(stream.complete() == late);
  }
}

TEST_CASE("a paced control that was overtaken by its frame is late") {
  PacedStream stream(8);
  stream.write();
  stream.complete();
  const auto due = stream.pacer.due();
  CHECK(stream.complete());
  stream.pacer.written(*due, stream.frame_begin);
  CHECK(stream.pacer.due()->request.cookie == 2);
}

TEST_CASE("an exposure beyond a camera's limits is refused with the limits") {
  CameraCapabilities camera;
  camera.id = "cam", camera.sets_exposure = true;
  camera.exposure_min = microseconds(100), camera.exposure_max = milliseconds(30), camera.gain_max = 8;
  CHECK(check_exposure(camera, {.exposure = milliseconds(30), .analogue_gain = 8}).ok());
  require_sentence(check_exposure(camera, {.exposure = milliseconds(31)}), ErrorCode::Invalid,
                   "100.0 to 30000.0 us");
  require_sentence(check_exposure(camera, {.exposure = microseconds(99)}), ErrorCode::Invalid, "99.0 us");
  require_sentence(check_exposure(camera, {.exposure = milliseconds(1), .analogue_gain = 9}),
                   ErrorCode::Invalid, "1.000 to 8.000");
  require_error(check_exposure(camera, {.exposure = milliseconds(1), .analogue_gain = std::nan("")}),
                ErrorCode::Invalid);
  camera.sets_exposure = false;
  CHECK(check_exposure(camera, {}).ok());
}

}  // namespace
}  // namespace hdrcam
