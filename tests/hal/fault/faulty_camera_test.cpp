#include "hal/fault/faulty_camera.h"

#include "hal/sim/simulated_camera.h"
#include "tests/contracts/camera_contract.h"
#include "tests/contracts/expect.h"

using namespace hdrcam;
using std::chrono::milliseconds;

namespace {

// A stream of a simulated camera whose third buffer (number 2) has the fault.
struct FaultyStream {
  explicit FaultyStream(CameraFaultKind kind) {
    auto inner =
        std::make_unique<SimulatedCamera>(value_of(simulation_of("still?size=32x24")), SimTime(clock), 1);
    camera = std::make_unique<FaultyCamera>(std::move(inner), std::vector<CameraFault>{{2, kind}});
    value_of(camera->configure({}, 4));
    require_done(camera->start());
    for (std::uint64_t i = 0; i < 4; ++i) require_done(camera->queue({i, milliseconds(1), 1}));
    first = next(), second = next();
  }
  CapturedBuffer next() { return value_of(camera->wait(std::chrono::seconds(1))); }

  VirtualClock clock;
  std::unique_ptr<FaultyCamera> camera;
  CapturedBuffer first, second;
};

}  // namespace

TEST_CASE("the faulty camera without faults keeps the camera contract") {
  keeps_camera_contract(
      {.name = "faulty",
       .open = []() -> Result<std::unique_ptr<Camera>> {
         return std::unique_ptr<Camera>(std::make_unique<FaultyCamera>(
             value_of(open_simulated_camera("still?size=32x24&fps=100")), std::vector<CameraFault>{}));
       },
       .mode = {PixelFormat::Rgb24, 32, 24, milliseconds(10)},
       .drops_frames = true});  // the camera inside keeps real time, and a busy machine is late
}

TEST_CASE("the faulty camera fails where it was told to, and nowhere else") {
  SECTION("timeout, once") {
    FaultyStream stream(CameraFaultKind::Timeout);
    require_error(stream.camera->wait(std::chrono::seconds(1)), ErrorCode::Timeout);
    CHECK(stream.next().sequence == stream.second.sequence + 1);
  }
  SECTION("unplug, for good") {
    FaultyStream stream(CameraFaultKind::Unplug);
    require_error(stream.camera->wait(std::chrono::seconds(1)), ErrorCode::Unplugged);
    require_error(stream.camera->queue({9, milliseconds(1), 1}), ErrorCode::Unplugged);
    require_done(stream.camera->stop());
    require_error(stream.camera->start(), ErrorCode::Unplugged);
  }
  SECTION("damaged, as the driver says") {
    FaultyStream stream(CameraFaultKind::Damaged);
    const CapturedBuffer buffer = stream.next();
    CHECK(buffer.damaged);
    CHECK(buffer.pixels.size() == stream.first.pixels.size() / 2);
    CHECK_FALSE(stream.next().damaged);
  }
  SECTION("short, and nobody says so") {
    FaultyStream stream(CameraFaultKind::Short);
    const CapturedBuffer buffer = stream.next();
    CHECK_FALSE(buffer.damaged);
    CHECK(buffer.pixels.size() == stream.first.pixels.size() / 2);
    CHECK(stream.next().pixels.size() == stream.first.pixels.size());
  }
  SECTION("a jump in the sequence stays") {
    FaultyStream stream(CameraFaultKind::SequenceJump);
    CHECK(stream.next().sequence == stream.second.sequence + 2);
    CHECK(stream.next().sequence == stream.second.sequence + 3);
  }
  SECTION("a repeated sequence number") {
    FaultyStream stream(CameraFaultKind::SequenceRepeat);
    CHECK(stream.next().sequence == stream.second.sequence);
    CHECK(stream.next().sequence == stream.second.sequence + 2);
  }
  SECTION("a stamp from the past") {
    FaultyStream stream(CameraFaultKind::StampBack);
    CHECK(stream.next().timestamp < stream.first.timestamp);
    CHECK(stream.next().timestamp > stream.second.timestamp);
  }
  SECTION("a repeated cookie") {
    FaultyStream stream(CameraFaultKind::CookieRepeat);
    CHECK(stream.next().cookie == stream.second.cookie);
    CHECK(stream.next().cookie == stream.second.cookie + 2);
  }
}
