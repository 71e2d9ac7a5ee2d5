#include "tests/hil/label_tally.h"

#include <fmt/format.h>

#include <cstdlib>

#include "hal/recording/recording.h"
#include "hal/storage.h"
#include "tests/contracts/expect.h"
#include "tests/hil/usb_camera/picture_stamp.h"

namespace hdrcam::hil {

void LabelTally::add(const RawFrame& frame) {
  const FrameFacts& facts = frame.facts;
  if ((facts.flags & kFrameAfterDrop) != 0) ++losses, since_loss_ = 0;
  const auto stamp = read_stamp(frame.codes);
  REQUIRE(stamp.has_value());
  const double truth = stamp->exposure_100us * 1e-4 * stamp->gain_16ths / 16;  // seconds x gain
  const bool same = facts.exposure() == Approx(truth).epsilon(1e-6);
  const bool vouched = (facts.flags & kFrameExposureUnproved) == 0;
  if (vouched)
    ++(same ? equal : wrong);
  else
    ++(since_loss_ < beginning ? flagged_early : flagged);
  ++frames, ++since_loss_;
  if (std::getenv("HIL_TRACE") != nullptr)
    fmt::print("  {:4} at {:.4f} s: {:.1f} ms, label {:.1f} ms {}{}{}\n", facts.sequence,
               facts.timestamp.seconds(), truth * 1e3, facts.exposure() * 1e3, name(facts.exposure_source),
               vouched ? "" : ", flagged", same ? "" : ", WRONG");
}

std::string LabelTally::text() const {
  return fmt::format("{} frames: {} equal, {} wrong, {} flagged in the first {}, {} later, {} losses", frames,
                     equal, wrong, flagged_early, beginning, flagged, losses);
}

LabelTally labels_of_recording(const std::string& path, int beginning) {
  const auto reader = value_of(open_recording(posix_storage(), path));
  LabelTally tally;
  tally.beginning = beginning;
  while (const auto frame = value_of(reader->next())) tally.add(*frame);
  return tally;
}

}  // namespace hdrcam::hil
