#include "hal/real/control_refusals.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

Error refusal(int code) { return {ErrorCode::Io, "'/dev/video5' refused to set its exposure", code}; }

TEST_CASE("exposures that a device does not take end a run only after many frames in a row") {
  ControlRefusals refusals;
  std::uint64_t frame = 0;
  for (int round = 0; round < 2; ++round) {
    for (int i = 1; i < ControlRefusals::kMostInARow; ++i) {
      require_done(refusals.answered(++frame, refusal(EIO)));
      require_done(refusals.answered(frame, refusal(EPIPE)));  // the same frame
    }
    require_done(refusals.answered(++frame, {}));
  }
  for (int i = 1; i < ControlRefusals::kMostInARow; ++i)
    require_done(refusals.answered(++frame, refusal(EBUSY)));
  const Result<void> last = refusals.answered(++frame, refusal(EBUSY));
  require_error(last, ErrorCode::Io);
  CHECK(last.error().message ==
        "'/dev/video5' refused to set its exposure, again and again; plug the camera in again, or check its "
        "cable");
  refusals.restart();
  require_done(refusals.answered(++frame, refusal(EBUSY)));
}

TEST_CASE("a device that lets every exposure time out ends a run before that takes minutes") {
  ControlRefusals refusals;
  for (const std::uint64_t frame : {1U, 1U, 2U, 2U})
    require_done(refusals.answered(frame, refusal(ETIMEDOUT)));
  require_error(refusals.answered(3, refusal(ETIMEDOUT)), ErrorCode::Io);
}

TEST_CASE("an exposure that a device will never take ends a run at once") {
  for (const int code : {EINVAL, EACCES, ERANGE, ENODEV}) {
    ControlRefusals refusals;
    require_error(refusals.answered(1, refusal(code)), ErrorCode::Io);
  }
}

}  // namespace
}  // namespace hdrcam
