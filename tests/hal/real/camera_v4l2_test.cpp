// A USB camera whose driver is the test's.
#include "hal/real/camera_v4l2.h"

#include <fcntl.h>
#include <linux/media.h>
#include <linux/videodev2.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <deque>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <utility>

#include "hal/real/control_refusals.h"
#include "hal/sim/virtual_clock.h"
#include "tests/contracts/expect.h"
#include "tests/support/answered_ioctl.h"
#include "tests/support/scratch_folder.h"

#include "tests/support/as_nobody.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;

constexpr StreamMode kMode{PixelFormat::Yuyv, 64, 48, milliseconds(33)};
constexpr std::uint32_t kStride = 2 * 64, kBytes = kStride * 48;

// It fills a queued buffer as soon as it is asked for one, and stamps the begin of the exposure.
struct UsbDriver {
  VirtualClock& clock;
  int refusal = EIO, refusals = 0;            // of the next exposures that are set
  std::optional<std::uint32_t> granted = {};  // buffers, whatever is asked for
  std::deque<std::uint32_t> queued{};
  std::uint32_t sequence = 0;
  std::string bus = "usb-0000:00:14.0-1";
  bool sets_exposure = true;  // on the capture node
  bool silent = false;        // it never fills a buffer
  int dequeues = 0;           // so often it was asked for a filled one
  // A media request for each buffer; its node is then in a media graph, without a sensor.
  bool takes_requests = false;
  std::set<int> used_requests{};
  bool renewed = false;  // the request of the next buffer

  template <class T>
  static T& as(void* argument) {
    return *static_cast<T*>(argument);
  }

  int operator()(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        as<v4l2_capability>(argument).capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        std::ranges::copy(bus, as<v4l2_capability>(argument).bus_info);
        return 0;
      case VIDIOC_ENUM_FMT:
        as<v4l2_fmtdesc>(argument).pixelformat = V4L2_PIX_FMT_YUYV;
        return as<v4l2_fmtdesc>(argument).index == 0 ? 0 : EINVAL;
      case VIDIOC_S_FMT:
        as<v4l2_format>(argument).fmt.pix.bytesperline = kStride;
        as<v4l2_format>(argument).fmt.pix.sizeimage = kBytes;
        return 0;
      case VIDIOC_REQBUFS:
        if (auto& count = as<v4l2_requestbuffers>(argument).count; count > 0) count = granted.value_or(count);
        if (takes_requests) as<v4l2_requestbuffers>(argument).capabilities = V4L2_BUF_CAP_SUPPORTS_REQUESTS;
        [[fallthrough]];
      case VIDIOC_STREAMON:
      case VIDIOC_STREAMOFF:
        queued.clear();
        return 0;
      case VIDIOC_QUERYBUF:
        as<v4l2_buffer>(argument).length = kBytes;
        return 0;
      case VIDIOC_QBUF:
        return queue(as<v4l2_buffer>(argument));
      case VIDIOC_DQBUF:
        ++dequeues;
        return silent || queued.empty() ? EAGAIN : fill(as<v4l2_buffer>(argument));
      default:
        return takes_requests && _IOC_TYPE(request) == '|' ? media(request, argument)
                                                           : control(request, argument);
    }
  }

  // A request that was queued takes no buffer until it is renewed.
  int queue(const v4l2_buffer& buffer) {
    const bool idle = std::exchange(renewed, false) || !used_requests.contains(buffer.request_fd);
    if ((buffer.flags & V4L2_BUF_FLAG_REQUEST_FD) != 0) {
      if (!idle) return EBUSY;
      used_requests.insert(buffer.request_fd);
    }
    queued.push_back(buffer.index);
    return 0;
  }

  int media(unsigned long request, void* argument) {
    switch (request) {
      case MEDIA_IOC_G_TOPOLOGY:
        describe(as<media_v2_topology>(argument));
        return 0;
      case MEDIA_IOC_REQUEST_ALLOC:
        as<int>(argument) = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
        return 0;
      case MEDIA_REQUEST_IOC_REINIT:
        renewed = true;
        return 0;
      default:
        return request == MEDIA_REQUEST_IOC_QUEUE ? 0 : ENOTTY;
    }
  }

  // One part, whose interface is its node: an ordinary file, so that its number is 0:0.
  static void describe(media_v2_topology& graph) {
    constexpr std::uint32_t kPart = 1, kInterface = 2;
    graph.num_entities = graph.num_interfaces = graph.num_links = 1;
    if (graph.ptr_entities == 0) return;
    auto& link = *reinterpret_cast<media_v2_link*>(graph.ptr_links);
    reinterpret_cast<media_v2_entity*>(graph.ptr_entities)->id = kPart;
    reinterpret_cast<media_v2_interface*>(graph.ptr_interfaces)->id = kInterface;
    link.source_id = kInterface, link.sink_id = kPart, link.flags = MEDIA_LNK_FL_INTERFACE_LINK;
  }

  int control(unsigned long request, void* argument) {
    if (request == VIDIOC_S_EXT_CTRLS) return refusals > 0 ? (--refusals, refusal) : 0;
    if (request == VIDIOC_G_EXT_CTRLS) return as<v4l2_ext_controls>(argument).controls[0].value = 100, 0;
    if (request == VIDIOC_S_CTRL) return 0;
    if (request != VIDIOC_QUERY_EXT_CTRL) return ENOTTY;
    auto& asked = as<v4l2_query_ext_ctrl>(argument);
    asked.minimum = 1, asked.maximum = 5000, asked.step = 1;
    return sets_exposure && asked.id == V4L2_CID_EXPOSURE_ABSOLUTE ? 0 : EINVAL;
  }

  int fill(v4l2_buffer& buffer) {
    clock.sleep_until(clock.now() + kMode.frame_duration);
    const Duration stamp = clock.now().since_boot - milliseconds(1);
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(stamp);
    buffer.timestamp.tv_sec = seconds.count();
    buffer.timestamp.tv_usec = std::chrono::duration_cast<std::chrono::microseconds>(stamp - seconds).count();
    buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    buffer.index = queued.front(), buffer.sequence = sequence++, buffer.bytesused = kBytes;
    queued.pop_front();
    return 0;
  }
};

// Its driver, and the camera with four buffers.
struct UsbCameraUnderTest {
  VirtualClock clock;
  UsbDriver driver{clock};
  test::AnsweredIoctl kernel{
      [this](unsigned long request, void* argument) { return driver(request, argument); }};
  std::string node = std::filesystem::canonical(test::scratch_folder("usb_driver")).string() + "/video0";
  std::unique_ptr<Camera> camera;

  UsbCameraUnderTest() {
    std::ofstream(node) << std::string(kBytes, '\0');  // what is mapped
    camera = value_of(open_v4l2_camera(node, {}, clock));
  }

  Result<void> queue_one() { return camera->queue({.exposure = milliseconds(5)}); }
  void start() {
    value_of(camera->configure(kMode, 4));
    require_done(camera->start());
    for (int i = 0; i < 4; ++i) require_done(queue_one());
  }
  // From now on poll() says of its node that it failed, as of the end of a pipe that nobody reads.
  void fail_in_poll() const {
    std::array<int, 2> pipe{};
    REQUIRE(::pipe2(pipe.data(), O_CLOEXEC) == 0);
    std::error_code gone;
    for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd"))
      if (std::filesystem::read_symlink(file, gone) == node)
        REQUIRE(::dup3(pipe[1], std::stoi(file.path().filename()), O_CLOEXEC) >= 0);
    for (const int end : pipe) ::close(end);
  }
  // Whether the exposure of the next frame was late. Its buffer is free again.
  bool next_is_late() { return value_of(camera->wait(std::chrono::seconds(1))).control_late; }
};

TEST_CASE("a USB camera that fails one transfer is asked again, and no exposure is late") {
  UsbCameraUnderTest usb;
  usb.start();
  for (int frame = 0; frame < 8; ++frame) {
    usb.driver.refusals = 1, usb.driver.refusal = frame % 2 == 0 ? EIO : EPIPE;
    CHECK_FALSE(usb.next_is_late());
    CHECK(usb.driver.refusals == 0);
    require_done(usb.queue_one());
  }
}

TEST_CASE("the frame whose exposure a USB camera did not take tells it, and the run goes on") {
  // tries: once its predecessor is complete, and once more when the next request comes, unless it timed out
  for (const auto& [code, tries] : {std::pair{EIO, 6}, {EPIPE, 6}, {EBUSY, 2}, {ETIMEDOUT, 1}}) {
    CAPTURE(code);
    UsbCameraUnderTest usb;
    usb.start();
    usb.driver.refusal = code, usb.driver.refusals = tries;
    for (int frame = 0; frame < 6; ++frame) {
      CHECK(usb.next_is_late() == (frame == 1));
      require_done(usb.queue_one());
    }
  }
}

TEST_CASE("a camera has as many buffers as its driver grants, fewer or more than asked for") {
  for (const int granted : {2, 4, 6}) {
    UsbCameraUnderTest usb;
    usb.driver.granted = granted;
    value_of(usb.camera->configure(kMode, 4));
    CHECK(usb.camera->capabilities().buffers == granted);
    require_done(usb.camera->start());
    for (int i = 0; i < granted; ++i) require_done(usb.queue_one());
    require_error(usb.queue_one(), ErrorCode::Busy);
    CHECK(usb.driver.queued.size() == static_cast<std::size_t>(granted));
  }
}

TEST_CASE("a driver that grants no buffer is told of where the camera is configured") {
  UsbCameraUnderTest usb;
  usb.driver.granted = 0;
  const auto configured = usb.camera->configure(kMode, 4);
  require_error(configured, ErrorCode::Io);
  CHECK(configured.error().message.find("no memory for a buffer") != std::string::npos);
}

TEST_CASE("a USB camera that takes no exposure any more ends the run, and one that never will does at once") {
  const int of_a_second = 2 + static_cast<int>(ControlRefusals::kLongest / kMode.frame_duration);
  for (const auto& [code, most_frames] : {std::pair{EIO, of_a_second}, {EINVAL, 1}}) {
    CAPTURE(code);
    UsbCameraUnderTest usb;
    usb.start();
    usb.driver.refusal = code, usb.driver.refusals = INT_MAX;
    Result<void> queued;
    int frames = 0;
    for (; queued.ok() && frames < 100; ++frames) {
      (void)usb.next_is_late();
      queued = usb.queue_one();
    }
    require_error(queued, code == EIO ? ErrorCode::Io : ErrorCode::Unsupported);
    CHECK(frames == most_frames);
  }
}

TEST_CASE("a camera that says it is ready, or that it failed, and has no frame keeps no processor busy") {
  for (const bool fails : {false, true}) {
    CAPTURE(fails);
    UsbCameraUnderTest usb;
    usb.start();
    usb.driver.silent = true;
    if (fails) usb.fail_in_poll();
    const auto waited = usb.camera->wait(milliseconds(200));
    require_error(waited, fails ? ErrorCode::Io : ErrorCode::Timeout);
    CHECK(usb.driver.dequeues < 100);
    CHECK_THAT(waited.error().message, Catch::Contains(fails ? "reports that its stream failed"
                                                             : "delivered no frame within 200 ms (check its "
                                                               "cable and hub; plug a USB camera in again, a "
                                                               "ribbon cable only with the power off)"));
  }
}

TEST_CASE("a camera that needs a sensor behind a media node that may not be opened says so when configured") {
  const std::string usb_bus = "usb-0000:00:14.0-1", csi_bus = "platform:fe801000.csi";
  for (const auto& [bus, sets_exposure] :
       {std::pair{csi_bus, false}, {csi_bus, true}, {usb_bus, true}, {usb_bus, false}}) {
    CAPTURE(bus, sets_exposure);
    UsbCameraUnderTest usb;
    usb.driver.bus = bus, usb.driver.sets_exposure = sets_exposure;
    std::filesystem::permissions(usb.node, std::filesystem::perms(0666));
    const std::string media = usb.node + "-media";
    std::ofstream(media) << "closed";
    std::filesystem::permissions(media, std::filesystem::perms::none);
    const test::AsNobody nobody;
    usb.camera = value_of(open_v4l2_camera(usb.node, {.media_nodes = {media}}, usb.clock));
    const auto configured = usb.camera->configure(kMode, 4);
    if (bus == usb_bus || sets_exposure) {  // all of it is on the capture node
      value_of(configured);
      continue;
    }
    require_error(configured, ErrorCode::Permission);
    CHECK_THAT(configured.error().message,
               Catch::StartsWith(fmt::format(
                   "the sensor of '{}' cannot be found: no permission for '{}': ", usb.node, media)));
  }
}

TEST_CASE("a queue that takes media requests delivers on and on, whether or not they set the exposure") {
  for (const bool sets_exposure : {true, false}) {
    CAPTURE(sets_exposure);
    UsbCameraUnderTest usb;
    usb.driver.takes_requests = true, usb.driver.sets_exposure = sets_exposure;
    const std::string media = usb.node + "-media";
    std::ofstream(media) << "open";
    usb.camera = value_of(open_v4l2_camera(usb.node, {.media_nodes = {media}}, usb.clock));
    usb.start();
    CHECK(usb.camera->capabilities().exposure_per_request == sets_exposure);
    for (int frame = 0; frame < 12; ++frame) {  // more than there are buffers
      value_of(usb.camera->wait(std::chrono::seconds(1)));
      require_done(usb.queue_one());
    }
  }
}

}  // namespace
}  // namespace hdrcam
