#include "hal/real/control_refusals.h"

#include <cerrno>
#include <cstdlib>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;

Error refusal(int code) { return {ErrorCode::Io, "'/dev/video5' refused to set its exposure", code}; }

// A camera that answers the exposures of one frame after the other.
struct RefusedFrames {
  ControlRefusals refusals{};
  Duration frame_duration;
  std::uint64_t frame = 0;
  Instant now{std::chrono::seconds(100)};

  Result<void> next(const Result<void>& answer) {
    now = now + frame_duration;
    return refusals.answered(++frame, answer, now);
  }
  Result<void> again(const Result<void>& answer) { return refusals.answered(frame, answer, now); }
  // Frames in a row until the run ends.
  int until_end(int code) {
    for (int frames = 1; frames <= 1000; ++frames)
      if (!next(refusal(code))) return frames;
    return 0;
  }
};

TEST_CASE("exposures that a device does not take end a run after a second of them, at any frame rate") {
  for (const int rate_hz : {2, 30, 120}) {
    CAPTURE(rate_hz);
    RefusedFrames camera{.frame_duration = Duration(std::chrono::seconds(1)) / rate_hz};
    CHECK(std::abs(camera.until_end(EIO) - (1 + rate_hz)) <= 1);
    camera.refusals.restart();
    require_done(camera.next(refusal(EIO)));
  }
}

TEST_CASE("an exposure that a device takes meanwhile begins the second anew") {
  RefusedFrames camera{.frame_duration = milliseconds(33)};
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 30; ++i) {
      require_done(camera.next(refusal(EIO)));
      require_done(camera.again(refusal(EPIPE)));
    }
    require_done(camera.next({}));
  }
  CHECK(camera.until_end(EIO) >= 30);
}

TEST_CASE("a run does not end before three frames were refused, however long they take") {
  for (const int code : {EIO, ETIMEDOUT}) {
    RefusedFrames camera{.frame_duration = std::chrono::seconds(5)};
    for (int i = 0; i < 2; ++i) {
      require_done(camera.next(refusal(code)));
      camera.now = camera.now + std::chrono::seconds(5);
      require_done(camera.again(refusal(code)));
    }
    require_error(camera.next(refusal(code)), ErrorCode::Io);
  }
}

TEST_CASE("the end of a run by refused exposures says what to do about this refusal") {
  const std::string cable =
      "; check its cable and hub; plug a USB camera in again, a ribbon cable only with the power off";
  const std::string program =
      "; stop the program that holds its controls ('hdrcam list' names one that has it open), or plug a "
      "USB camera in again";
  for (const auto& [code, advice] :
       {std::pair{EBUSY, program}, {EIO, cable}, {EPIPE, cable}, {EPROTO, cable}, {ETIMEDOUT, cable}}) {
    RefusedFrames camera{.frame_duration = milliseconds(400)};
    for (int i = 0; i < 3; ++i) require_done(camera.next(refusal(code)));
    const Result<void> last = camera.next(refusal(code));
    require_error(last, ErrorCode::Io);
    CHECK(last.error().message == "'/dev/video5' refused to set its exposure, again and again" + advice);
  }
}

TEST_CASE("an exposure that a device will never take ends a run at once") {
  for (const int code : {EINVAL, EACCES, ERANGE, ENODEV}) {
    RefusedFrames camera{.frame_duration = milliseconds(33)};
    const Result<void> first = camera.next(refusal(code));
    require_error(first, ErrorCode::Io);
    CHECK((first.error().message.find("automatic exposure on again: stop that") != std::string::npos) ==
          (code == EACCES));
  }
}

}  // namespace
}  // namespace hdrcam
