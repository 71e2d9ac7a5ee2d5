// What the driver of a capture queue answers, by the test.
#include "hal/real/v4l2_stream.h"

#include <linux/videodev2.h>

#include <cerrno>

#include "tests/contracts/expect.h"
#include "tests/support/answered_ioctl.h"

namespace hdrcam {
namespace {

struct PlaneBytes {
  std::uint32_t used, offset;
};

V4l2Stream::Filled filled_of(std::uint32_t queue, const PlaneBytes& plane) {
  const DeviceNode video = value_of(DeviceNode::open("/dev/null"));
  const test::AnsweredIoctl driver([&](unsigned long request, void* argument) {
    if (request != VIDIOC_DQBUF) return EINVAL;
    auto& buffer = *static_cast<v4l2_buffer*>(argument);
    if (queue == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE)
      buffer.m.planes[0].bytesused = plane.used, buffer.m.planes[0].data_offset = plane.offset;
    else
      buffer.bytesused = plane.used;
    return 0;
  });
  V4l2Stream stream(video, nullptr, queue);
  const auto filled = value_of(stream.dequeue());
  REQUIRE(filled);
  return *filled;
}

TEST_CASE("the bytes of a picture are those that its plane holds behind the offset of its data") {
  const auto behind = filled_of(V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE, {1064, 64});
  CHECK(behind.begin == 64);
  CHECK(behind.bytes == 1000);
  const auto nothing = filled_of(V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE, {0, 64});
  CHECK(nothing.bytes == 0);
  const auto single = filled_of(V4L2_BUF_TYPE_VIDEO_CAPTURE, {1000, 0});
  CHECK(single.begin == 0);
  CHECK(single.bytes == 1000);
}

}  // namespace
}  // namespace hdrcam
