// What the driver of a capture node answers, by the test, and which modes follow.
#include "hal/real/v4l2_modes.h"

#include <linux/videodev2.h>

#include <cerrno>

#include "hal/real/v4l2_formats.h"
#include "tests/contracts/expect.h"
#include "tests/support/answered_ioctl.h"

namespace hdrcam {
namespace {

DeviceNode node() { return value_of(DeviceNode::open("/dev/null")); }

// Lists one format and answers the rest with EINVAL, as a driver that lists no sizes.
int list_one(unsigned long request, void* argument, PixelFormat format) {
  if (request != VIDIOC_ENUM_FMT) return EINVAL;
  auto& listed = *static_cast<v4l2_fmtdesc*>(argument);
  if (listed.index > 0) return EINVAL;
  listed.pixelformat = fourcc_of(format);
  return 0;
}

TEST_CASE("a format that the driver refuses is refused, with those that it offers") {
  const DeviceNode video = node();
  const test::AnsweredIoctl driver(
      [](unsigned long request, void* argument) { return list_one(request, argument, PixelFormat::Yuyv); });
  for (const std::uint32_t queue : {V4L2_BUF_TYPE_VIDEO_CAPTURE, V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE}) {
    const auto refused = set_mode(video, queue, {PixelFormat::Rggb10, 640, 480, Duration(33'333'333)});
    require_error(refused, ErrorCode::Unsupported);
    INFO(refused.error().message);
    CHECK(refused.error().message.find("does not offer ") != std::string::npos);
    CHECK(refused.error().message.find("it offers " + std::string(name(PixelFormat::Yuyv))) !=
          std::string::npos);
  }
}

TEST_CASE("a driver that lists no sizes is asked for the one that it has, of its own kind of queue") {
  const DeviceNode video = node();
  for (const std::uint32_t queue : {V4L2_BUF_TYPE_VIDEO_CAPTURE, V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE}) {
    const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
      if (request != VIDIOC_G_FMT) return list_one(request, argument, PixelFormat::Rggb10);
      auto& format = *static_cast<v4l2_format*>(argument);
      if (format.type != queue) return EINVAL;
      if (queue == V4L2_BUF_TYPE_VIDEO_CAPTURE)
        format.fmt.pix.width = 1456, format.fmt.pix.height = 1088;
      else
        format.fmt.pix_mp.width = 1456, format.fmt.pix_mp.height = 1088;
      return 0;
    });
    const auto modes = modes_of(video, queue);
    REQUIRE(modes.size() == 1);
    CHECK(modes[0].format == PixelFormat::Rggb10);
    CHECK(modes[0].width == 1456);
    CHECK(modes[0].height == 1088);
  }
}

TEST_CASE("a driver that scales offers the usual size, where it has it, and its largest") {
  const DeviceNode video = node();
  const auto sizes_of = [&](const v4l2_frmsize_stepwise& range) {
    const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
      if (request != VIDIOC_ENUM_FRAMESIZES) return list_one(request, argument, PixelFormat::Nv12);
      auto& listed = *static_cast<v4l2_frmsizeenum*>(argument);
      listed.type = V4L2_FRMSIZE_TYPE_STEPWISE, listed.stepwise = range;
      return listed.index > 0 ? EINVAL : 0;
    });
    std::string sizes;
    for (const StreamMode& mode : modes_of(video, V4L2_BUF_TYPE_VIDEO_CAPTURE))
      sizes += fmt::format(" {}x{}", mode.width, mode.height);
    return sizes;
  };
  CHECK(sizes_of({64, 4056, 2, 64, 3040, 2}) == " 640x480 4056x3040");
  CHECK(sizes_of({64, 4056, 0, 64, 3040, 0}) == " 640x480 4056x3040");
  CHECK(sizes_of({32, 4064, 32, 24, 3000, 24}) == " 640x480 4064x3000");
  CHECK(sizes_of({100, 4100, 64, 64, 3040, 2}) == " 4100x3040");
  CHECK(sizes_of({16, 640, 1, 16, 480, 1}) == " 640x480");
  CHECK(sizes_of({16, 320, 1, 16, 240, 1}) == " 320x240");
}

TEST_CASE("a driver that knows no frame interval has the usual one") {
  const DeviceNode video = node();
  for (const v4l2_fract& interval : {v4l2_fract{0, 30}, v4l2_fract{0, 0}, v4l2_fract{1, 0}}) {
    const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
      if (request == VIDIOC_G_FMT) return 0;
      if (request != VIDIOC_ENUM_FRAMEINTERVALS) return list_one(request, argument, PixelFormat::Yuyv);
      auto& listed = *static_cast<v4l2_frmivalenum*>(argument);
      if (listed.index > 0) return EINVAL;
      listed.type = V4L2_FRMIVAL_TYPE_DISCRETE, listed.discrete = interval;
      return 0;
    });
    const auto modes = modes_of(video, V4L2_BUF_TYPE_VIDEO_CAPTURE);
    REQUIRE(modes.size() == 1);
    CHECK(modes[0].frame_duration == kUsualFrameDuration);
  }
}

TEST_CASE("a whole picture is what its rows need, however the driver pads its buffers") {
  const DeviceNode video = node();
  constexpr std::uint32_t kPadded = 4'000'000;
  const auto bytes_of = [&](std::uint32_t queue, PixelFormat pixels, std::uint32_t stride) {
    const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
      if (request != VIDIOC_S_FMT) return EINVAL;
      auto& format = *static_cast<v4l2_format*>(argument);
      if (queue == V4L2_BUF_TYPE_VIDEO_CAPTURE) {
        format.fmt.pix.bytesperline = stride, format.fmt.pix.sizeimage = kPadded;
      } else {
        auto& plane = format.fmt.pix_mp.plane_fmt[0];
        plane.bytesperline = stride, plane.sizeimage = kPadded, format.fmt.pix_mp.num_planes = 1;
      }
      return 0;
    });
    return value_of(set_mode(video, queue, {pixels, 640, 480, Duration(33'333'333)})).bytes;
  };
  for (const std::uint32_t queue : {V4L2_BUF_TYPE_VIDEO_CAPTURE, V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE}) {
    CHECK(bytes_of(queue, PixelFormat::Rggb10, 1344) == 1344 * 479 + 1280);
    CHECK(bytes_of(queue, PixelFormat::Nv12, 704) == 704 * 719 + 640);
    CHECK(bytes_of(queue, PixelFormat::Mjpeg, 0) == kPadded);
  }
}

TEST_CASE("a capture card whose signal is interlaced is refused, and one that has no fields is not") {
  const DeviceNode video = node();
  const auto answer_with = [&](std::uint32_t queue, std::uint32_t field) {
    const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
      if (request != VIDIOC_S_FMT) return EINVAL;
      auto& format = *static_cast<v4l2_format*>(argument);
      if (queue == V4L2_BUF_TYPE_VIDEO_CAPTURE)
        format.fmt.pix.field = field;
      else
        format.fmt.pix_mp.field = static_cast<std::uint8_t>(field), format.fmt.pix_mp.num_planes = 1;
      return 0;
    });
    return set_mode(video, queue, {PixelFormat::Yuyv, 720, 576, std::chrono::milliseconds(40)});
  };
  for (const std::uint32_t queue : {V4L2_BUF_TYPE_VIDEO_CAPTURE, V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE}) {
    for (const std::uint32_t whole : {V4L2_FIELD_NONE, V4L2_FIELD_ANY}) CHECK(answer_with(queue, whole).ok());
    for (const std::uint32_t woven : {V4L2_FIELD_INTERLACED, V4L2_FIELD_INTERLACED_TB,
                                      V4L2_FIELD_INTERLACED_BT, V4L2_FIELD_SEQ_TB, V4L2_FIELD_SEQ_BT}) {
      CAPTURE(queue, woven);
      const auto refused = answer_with(queue, woven);
      require_error(refused, ErrorCode::Unsupported);
      CHECK_THAT(refused.error().message, Catch::Contains("rows are of two moments"));
    }
    for (const std::uint32_t single : {V4L2_FIELD_TOP, V4L2_FIELD_BOTTOM, V4L2_FIELD_ALTERNATE}) {
      CAPTURE(queue, single);
      const auto refused = answer_with(queue, single);
      require_error(refused, ErrorCode::Unsupported);
      CHECK_THAT(refused.error().message, Catch::Contains("single fields"));
    }
  }
}

TEST_CASE("a frame duration that the driver does not take is the one that it has") {
  const DeviceNode video = node();
  struct Driver {
    std::uint32_t can, frames_per_second;  // 0: it does not say
    int answer;                            // to one that is set
    int milliseconds;
  };
  constexpr std::uint32_t kSets = V4L2_CAP_TIMEPERFRAME;
  const Driver kDrivers[] = {
      {kSets, 50, 0, 40}, {kSets, 50, EIO, 20}, {0, 50, 0, 20}, {0, 0, 0, 40}, {kSets, 0, EINVAL, 40}};
  for (const Driver& has : kDrivers) {
    const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
      if (request == VIDIOC_S_FMT) return 0;
      if (request == VIDIOC_S_PARM) return has.answer;
      if (request != VIDIOC_G_PARM) return EINVAL;
      auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
      capture.capability = has.can;
      if (has.frames_per_second > 0) capture.timeperframe = {1, has.frames_per_second};
      return 0;
    });
    CAPTURE(has.can, has.frames_per_second, has.answer);
    const auto picture = value_of(set_mode(video, V4L2_BUF_TYPE_VIDEO_CAPTURE,
                                           {PixelFormat::Yuyv, 640, 480, std::chrono::milliseconds(40)}));
    CHECK(picture.mode.frame_duration == std::chrono::milliseconds(has.milliseconds));
  }
}

TEST_CASE("matrix and range of YUV are what the driver reports, or what its colour space stands for") {
  const DeviceNode video = node();
  struct Report {
    std::uint32_t colour_space, encoding, quantization;
    YuvCoding coding;
  };
  const Report kReports[] = {
      {V4L2_COLORSPACE_DEFAULT, 0, 0, {YuvMatrix::Bt601, YuvRange::Limited}},
      {V4L2_COLORSPACE_SRGB, 0, 0, {YuvMatrix::Bt601, YuvRange::Limited}},
      {V4L2_COLORSPACE_JPEG, 0, 0, {YuvMatrix::Bt601, YuvRange::Full}},
      {V4L2_COLORSPACE_REC709, 0, 0, {YuvMatrix::Bt709, YuvRange::Limited}},
      {V4L2_COLORSPACE_BT2020, 0, 0, {YuvMatrix::Bt2020, YuvRange::Limited}},
      {V4L2_COLORSPACE_SRGB,
       V4L2_YCBCR_ENC_709,
       V4L2_QUANTIZATION_FULL_RANGE,
       {YuvMatrix::Bt709, YuvRange::Full}},
      {V4L2_COLORSPACE_JPEG, 0, V4L2_QUANTIZATION_LIM_RANGE, {YuvMatrix::Bt601, YuvRange::Limited}},
  };
  for (const std::uint32_t queue : {V4L2_BUF_TYPE_VIDEO_CAPTURE, V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE})
    for (const Report& report : kReports) {
      const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
        if (request != VIDIOC_S_FMT) return EINVAL;
        auto& format = *static_cast<v4l2_format*>(argument);
        if (queue == V4L2_BUF_TYPE_VIDEO_CAPTURE) {
          auto& pix = format.fmt.pix;
          pix.colorspace = report.colour_space, pix.ycbcr_enc = report.encoding;
          pix.quantization = report.quantization;
        } else {
          auto& pix = format.fmt.pix_mp;
          pix.colorspace = report.colour_space, pix.num_planes = 1;
          pix.ycbcr_enc = static_cast<std::uint8_t>(report.encoding);
          pix.quantization = static_cast<std::uint8_t>(report.quantization);
        }
        return 0;
      });
      CAPTURE(queue, report.colour_space, report.encoding, report.quantization);
      const auto picture =
          value_of(set_mode(video, queue, {PixelFormat::Yuyv, 640, 480, Duration(33'333'333)}));
      CHECK(picture.yuv == report.coding);
    }
}

TEST_CASE("a camera may have its exposure on a sensor's node, but not one on USB, nor a loopback") {
  V4l2Identity csi, usb, loopback;
  csi.bus = "platform:fe801000.csi";
  usb.bus = "usb-0000:00:14.0-1";
  loopback.driver = "v4l2 loopback", loopback.bus = "platform:v4l2loopback-000";
  CameraCapabilities camera;
  for (const V4l2Identity& fixed : {usb, loopback}) CHECK_FALSE(needs_sensor_node(fixed, camera));
  CHECK(needs_sensor_node(csi, camera));
  camera.sets_exposure = true;  // on the capture node
  CHECK_FALSE(needs_sensor_node(csi, camera));
  csi.media_controlled = true;
  CHECK(needs_sensor_node(csi, camera));
}

TEST_CASE("a capture card, whose input is a video signal, has no sensor, and other devices on its bus may") {
  const DeviceNode video = node();
  for (const int input : {0, V4L2_IN_CAP_DV_TIMINGS, V4L2_IN_CAP_STD}) {
    const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
      if (request == VIDIOC_QUERYCAP) return 0;
      if (request == VIDIOC_G_INPUT) return *static_cast<int*>(argument) = 1, 0;
      if (request != VIDIOC_ENUMINPUT) return EINVAL;
      auto& asked = *static_cast<v4l2_input*>(argument);
      asked.capabilities = asked.index == 1 ? static_cast<std::uint32_t>(input) : 0;
      return 0;
    });
    const V4l2Identity identity = value_of(identify(video));
    CAPTURE(input);
    CHECK(identity.takes_signal == (input != 0));
    CHECK(needs_sensor_node(identity, CameraCapabilities()) == (input == 0));
  }
}

}  // namespace
}  // namespace hdrcam
