#include "capture/request_queue.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}};

// Takes as many requests as it has free buffers.
class FewBuffers : public Camera {
 public:
  explicit FewBuffers(int buffers) : free(buffers) {}
  const CameraCapabilities& capabilities() const override { return capabilities_; }
  Result<StreamMode> configure(const StreamMode& wanted, int) override { return wanted; }
  Result<void> start() override { return {}; }
  Result<void> queue(const ExposureRequest& request) override {
    if (unplugged) return Error{ErrorCode::Unplugged, "gone"};
    if (free == 0) return Error{ErrorCode::Busy, "no buffer"};
    --free;
    cookies.push_back(request.cookie);
    return {};
  }
  Result<CapturedBuffer> wait(Duration) override { return Error{ErrorCode::Timeout, "none"}; }
  Result<void> stop() override { return {}; }

  int free;
  bool unplugged = false;
  std::vector<std::uint64_t> cookies;  // of the requests that it took

 private:
  CameraCapabilities capabilities_;
};

FrameMatcher matcher() { return FrameMatcher({}, ExposureSchedule::observed(kCycle).value()); }

TEST_CASE("a device with fewer buffers than requested is kept full, and no request is late", "[capture]") {
  FewBuffers camera(3);
  FrameMatcher requests = matcher();
  RequestQueue queue(camera);
  REQUIRE(queue.fill(requests, 8).ok());
  CHECK(camera.cookies.size() == 3);
  for (std::uint64_t i = 0; i < 10; ++i) {
    queue.completed();
    ++camera.free;
    const Result<bool> in_time = queue.top_up(requests);
    REQUIRE(in_time.ok());
    CHECK(in_time.value());
    CHECK(camera.cookies.back() == 3 + i);
  }
}

TEST_CASE("a request that finds no free buffer is queued later, in its place", "[capture]") {
  FewBuffers camera(3);
  FrameMatcher requests = matcher();
  RequestQueue queue(camera);
  REQUIRE(queue.fill(requests, 3).ok());
  queue.completed();  // but a slow consumer keeps the buffer
  const Result<bool> in_time = queue.top_up(requests);
  REQUIRE(in_time.ok());
  CHECK_FALSE(in_time.value());
  queue.completed();
  camera.free = 2;
  REQUIRE(queue.top_up(requests).ok());
  CHECK(camera.cookies == std::vector<std::uint64_t>{0, 1, 2, 3, 4});
}

TEST_CASE("what the camera says of a request is passed on", "[capture]") {
  FewBuffers camera(3);
  FrameMatcher requests = matcher();
  RequestQueue queue(camera);
  camera.unplugged = true;
  const Result<void> filled = queue.fill(requests, 3);
  REQUIRE_FALSE(filled.ok());
  CHECK(filled.error().code == ErrorCode::Unplugged);
}

}  // namespace
}  // namespace hdrcam
