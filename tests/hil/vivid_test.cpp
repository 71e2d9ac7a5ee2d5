// The kernel's virtual camera: it takes a control with each frame (request API) and has every pixel format.
#include <linux/v4l2-controls.h>
#include <linux/videodev2.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <optional>

#include "capture/capture_stage.h"
#include "capture/pixel_unpack.h"
#include "hal/real/camera_v4l2.h"
#include "hal/real/device_node.h"
#include "tests/contracts/camera_contract.h"
#include "tests/contracts/expect.h"
#include "tests/hil/bed.h"

namespace hdrcam::hil {
namespace {

using std::chrono::milliseconds;

// It has no exposure; its brightness changes the picture alike.
const V4l2Options kBrightnessIsExposure{
    .exposure_control = PrivateExposureControl{V4L2_CID_BRIGHTNESS, std::chrono::microseconds(100)}};
constexpr StreamMode kMode{PixelFormat::Yuyv, 640, 360, milliseconds(33)};

std::unique_ptr<Camera> vivid(const V4l2Options& options = {}) {
  return value_of(open_v4l2_camera(video_node("vivid-000-vid-cap"), options));
}

// Below the middle: the driver writes text above.
double mean_green(const Image<std::uint16_t>& codes) {
  double sum = 0;
  const int rows = codes.rows() / 2, first = codes.rows() - rows;
  for (int y = first; y < codes.rows(); ++y)
    for (int x = 0; x < codes.cols(); ++x) sum += codes.at(1, y, x);
  return sum / (static_cast<double>(rows) * codes.cols());
}

// The driver's own control of that name, as its menus count.
void set_by_name(const DeviceNode& node, std::string_view name, int value) {
  v4l2_queryctrl control{};
  control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (; node.ask(VIDIOC_QUERYCTRL, &control) == 0; control.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
    if (reinterpret_cast<const char*>(control.name) != name) continue;
    v4l2_control setting{control.id, value};
    REQUIRE(node.ask(VIDIOC_S_CTRL, &setting) == 0);
    return;
  }
  FAIL("vivid has no control '" << name << "'");
}

Image<std::uint16_t> picture_of(Camera& camera, PixelFormat format) {
  value_of(camera.configure({format, kMode.width, kMode.height, kMode.frame_duration}, 3));
  require_done(camera.start());
  require_done(camera.queue({}));
  Image<std::uint16_t> codes;
  require_done(unpack_pixels(value_of(camera.wait(std::chrono::seconds(5))), {}, codes));
  require_done(camera.stop());
  return codes;
}

TEST_CASE("vivid keeps the camera contract") {
  keeps_camera_contract(
      {.name = "vivid",
       .open = [] { return open_v4l2_camera(video_node("vivid-000-vid-cap"), kBrightnessIsExposure); },
       .mode = kMode,
       .frames = 20,
       .drops_frames = true,
       .repeats_sequence = true});
}

TEST_CASE("vivid's multi-planar queue keeps the camera contract") {
  keeps_camera_contract(
      {.name = "vivid, multi-planar",
       .open = [] { return open_v4l2_camera(video_node("vivid-001-vid-cap"), kBrightnessIsExposure); },
       .mode = kMode,
       .frames = 20,
       .drops_frames = true,
       .repeats_sequence = true});
}

TEST_CASE("a frame of vivid carries the control of its own request") {
  auto camera = vivid(kBrightnessIsExposure);
  value_of(camera->configure(kMode, 8));
  require_done(camera->start());
  REQUIRE(camera->capabilities().exposure_per_request);
  const auto exposure_of = [](std::uint64_t cookie) { return milliseconds(cookie % 3 == 0 ? 20 : 5); };
  std::uint64_t queued = 0;
  const auto queue = [&] {
    ExposureRequest request{.cookie = queued, .exposure = exposure_of(queued)};
    require_done(camera->queue(request));
    ++queued;
  };
  while (queued < 8) queue();
  std::optional<double> dark, bright;
  for (int i = 0; i < 60; ++i) {
    {
      const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(5)));
      const Duration wanted = exposure_of(buffer.cookie);
      INFO("frame " << i);
      REQUIRE(buffer.exposure.has_value());
      REQUIRE(*buffer.exposure == wanted);
      auto& mean = wanted == milliseconds(20) ? bright : dark;
      const double shown = mean_code(buffer);
      if (mean) REQUIRE(shown == Approx(*mean).margin(8));
      mean = shown;
    }
    queue();
  }
  CHECK(*bright > *dark + 30);
}

TEST_CASE("vivid's frames are labelled with the control of their own request") {
  constexpr Exposure kCycle[] = {{milliseconds(5), 1}, {milliseconds(10), 1}, {milliseconds(20), 1}};
  constexpr int kFrames = 120;
  const auto camera = vivid(kBrightnessIsExposure);
  const auto stage =
      value_of(CaptureStage::open(*camera, nullptr, kCycle, Mains::Off, {.mode = kMode, .buffers = 8}));
  CHECK(stage->warnings().empty());
  require_done(stage->start());
  CapturedFrame frame;
  std::array<std::optional<double>, 3> mean{};  // of green, by slot
  int trusted = 0, reported = 0;
  for (int i = 0; i < kFrames; ++i) {
    require_done(stage->next(frame));
    const FrameFacts& facts = frame.raw.facts;
    INFO("frame " << i);
    const std::size_t slot = frame.cookie % 3;
    CHECK(facts.exposure_s == Approx(to_seconds(kCycle[slot].time)));
    reported += facts.exposure_source == ExposureSource::Reported ? 1 : 0;
    trusted += frame.proof.trusted() ? 1 : 0;
    const double shown = mean_green(frame.raw.codes);
    if (mean[slot]) REQUIRE(shown == Approx(*mean[slot]).margin(8));
    mean[slot] = shown;
  }
  fmt::print("vivid: {} frames, {} reported, {} trusted, {} proved, {} contradicted\n", kFrames, reported,
             trusted, stage->counters().proved, stage->counters().contradicted);
  CHECK(reported == kFrames);
  CHECK(*mean[0] < *mean[1] - 5);
  CHECK(*mean[1] < *mean[2] - 5);
}

TEST_CASE("a camera that was driven has its controls as they were before") {
  const DeviceNode node = value_of(DeviceNode::open(video_node("vivid-000-vid-cap")));
  v4l2_control brightness{V4L2_CID_BRIGHTNESS, 77}, automatic{V4L2_CID_AUTOGAIN, 1};
  for (v4l2_control* control : {&brightness, &automatic}) REQUIRE(node.ask(VIDIOC_S_CTRL, control) == 0);
  {
    const auto camera = vivid(kBrightnessIsExposure);
    value_of(camera->configure(kMode, 4));
    require_done(camera->start());
    require_done(camera->queue({.cookie = 0, .exposure = milliseconds(20)}));
    value_of(camera->wait(std::chrono::seconds(5)));
    REQUIRE(node.ask(VIDIOC_G_CTRL, &automatic) == 0);
    CHECK(automatic.value == 0);
  }
  for (v4l2_control* control : {&brightness, &automatic}) REQUIRE(node.ask(VIDIOC_G_CTRL, control) == 0);
  CHECK(brightness.value == 77);
  CHECK(automatic.value == 1);
}

TEST_CASE("a camera says where in a frame its driver takes the timestamp") {
  const auto of_vivid = vivid();
  value_of(of_vivid->configure(kMode, 4));
  CHECK((of_vivid->capabilities().timestamp_mark == TimestampMark::ExposureEnd));
  const UsbCamera plugged(0);
  const auto of_usb = value_of(open_v4l2_camera(plugged.node()));
  value_of(of_usb->configure({PixelFormat::Yuyv, 320, 240, milliseconds(33)}, 4));
  CHECK((of_usb->capabilities().timestamp_mark == TimestampMark::ExposureBegin));
}

TEST_CASE("vivid delivers every format that it agrees to") {
  auto camera = vivid();
  int tried = 0;
  PixelFormat last = PixelFormat::Mjpeg;
  for (const StreamMode& mode : std::vector<StreamMode>(camera->capabilities().modes)) {
    if (mode.format == last || mode.width > 640) continue;
    last = mode.format;
    INFO(name(mode.format) << " " << mode.width << " x " << mode.height);
    const StreamMode agreed = value_of(camera->configure(mode, 3));
    CHECK(agreed.format == mode.format);
    require_done(camera->start());
    require_done(camera->queue({}));
    {
      const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(5)));
      CHECK_FALSE(buffer.damaged);
      CHECK(buffer.pixels.size() >= buffer.stride * static_cast<std::size_t>(agreed.height));
      CHECK(buffer.dmabuf_fd >= 0);
      CHECK(mean_code(buffer) > 1);
    }
    require_done(camera->stop());
    ++tried;
  }
  CHECK(tried >= 20);  // RGB, BGR, YUYV, NV12, grey, and Bayer of 8, 10, 12 and 16 bits in four orders
}

TEST_CASE("colours are the same by whatever matrix and range vivid makes YUV of them") {
  constexpr int kEncodings[] = {V4L2_YCBCR_ENC_DEFAULT, V4L2_YCBCR_ENC_601, V4L2_YCBCR_ENC_709,
                                V4L2_YCBCR_ENC_BT2020};
  constexpr int kRanges[] = {V4L2_QUANTIZATION_DEFAULT, V4L2_QUANTIZATION_FULL_RANGE,
                             V4L2_QUANTIZATION_LIM_RANGE};
  const auto camera = vivid();
  const DeviceNode node = value_of(DeviceNode::open(video_node("vivid-000-vid-cap")));
  set_by_name(node, "Brightness", 128);  // the usual one: another acts on codes of luma, whatever their range
  const Image<std::uint16_t> rgb = picture_of(*camera, PixelFormat::Rgb24);
  for (const PixelFormat format : {PixelFormat::Yuyv, PixelFormat::Nv12})
    for (const int encoding : kEncodings)
      for (const int range : kRanges) {
        INFO(name(format) << ", encoding " << encoding << ", range " << range);
        set_by_name(node, "Y'CbCr Encoding", encoding);
        set_by_name(node, "Quantization", range);
        const Image<std::uint16_t> codes = picture_of(*camera, format);
        int off = 0, all = 0;  // but for edges, where colour is shared
        for (int y = codes.rows() / 2; y < codes.rows(); ++y)
          for (int x = 0; x < codes.cols(); ++x, ++all)
            for (int c = 0; c < 3; ++c) off += std::abs(codes.at(c, y, x) - rgb.at(c, y, x)) > 6 ? 1 : 0;
        CHECK(off < all / 10);
      }
  set_by_name(node, "Y'CbCr Encoding", V4L2_YCBCR_ENC_DEFAULT);
  set_by_name(node, "Quantization", V4L2_QUANTIZATION_DEFAULT);
}

TEST_CASE("a format that vivid does not have is refused with those that it has") {
  auto camera = vivid();
  const auto refused = camera->configure({PixelFormat::Mjpeg, 640, 360}, 4);
  require_error(refused, ErrorCode::Unsupported);
  CHECK(refused.error().message.find("YUYV") != std::string::npos);
}

TEST_CASE("a camera that somebody streams from is busy, and another process that holds it is named") {
  auto first = vivid();
  value_of(first->configure(kMode, 4));
  require_done(first->start());
  const auto said_to_a_second = [] {
    const auto refused = vivid()->configure(kMode, 4);
    require_error(refused, ErrorCode::Busy);
    return refused.error().message;
  };
  CHECK(said_to_a_second().find("hdrcam_hil") == std::string::npos);

  const pid_t other = ::fork();  // it has the camera open, too
  REQUIRE(other >= 0);
  if (other == 0)
    for (;;) ::pause();
  const std::string said = said_to_a_second();
  ::kill(other, SIGKILL);
  ::waitpid(other, nullptr, 0);
  CHECK(said.find("'hdrcam_hil' (process " + std::to_string(other) + ")") != std::string::npos);
}

}  // namespace
}  // namespace hdrcam::hil
