#include "capture/exposed_stream.h"

#include <algorithm>
#include <cmath>

#include "capture/companding.h"
#include "capture/exposure.h"
#include "hal/recording/exposure_cycle.h"

namespace hdrcam {
namespace {

// Geometric mean of the exposures of one cycle: each slot counts once, by its first frame, so that lost
// frames change nothing. Where no cycle is found, each distinct exposure does. Where frames state slots,
// those without one are left out, as those before the first control acted.
double cycle_mean(const std::vector<RawFrame>& frames) {
  std::vector<FrameFacts> facts;
  for (const RawFrame& frame : frames) facts.push_back(frame.facts);
  const ExposureCycle cycle = find_exposure_cycle(facts);
  const bool states_slots = std::ranges::any_of(facts, [](const FrameFacts& f) { return f.slot >= 0; });
  struct Counted {
    int slot = -1;  // none where no cycle is found
    double log_exposure = 0;
  };
  std::vector<Counted> counted;
  double sum = 0;
  for (const FrameFacts& frame : facts) {
    if (states_slots && frame.slot < 0) continue;
    // a cycle of one may be exposures that differ less than the search tolerates
    const int slot = cycle.period > 1 ? slot_of(cycle, facts.front(), frame) : -1;
    const double log_exposure = std::log(frame.exposure());
    const auto repeats = [&](const Counted& other) {
      return slot >= 0 ? other.slot == slot : std::abs(other.log_exposure - log_exposure) < kSameInCycle;
    };
    if (std::ranges::any_of(counted, repeats)) continue;
    counted.push_back({slot, log_exposure});
    sum += log_exposure;
  }
  return std::exp(sum / static_cast<double>(counted.size()));
}

// From black to the largest code. A stated black level is the same in all channels.
float range_above(const BlackLevel& black_level) {
  constexpr std::size_t kGreen = 1;
  return kMaxCode - black_level[kGreen];
}

}  // namespace

ExposedStream::ExposedStream(const CameraFacts& camera, int first_frames, StatedBlack stated_black)
    : first_frames_(static_cast<std::size_t>(first_frames)),
      stated_black_(stated_black),
      is_companded_(is_companded(camera)) {
  if (stated_black_ == StatedBlack::Kept) white_search_.emplace(camera);
  settings_.bits = camera.bits;
  settings_.layout = camera.layout;
  if (camera.framerate_hz > 0) settings_.frame_s = 1 / camera.framerate_hz;
}

Result<void> ExposedStream::take(const RawFrame& raw, const HandOn& hand_on) {
  TRY(check_exposure(raw.facts));
  if (!started_) {
    waiting_.push_back({raw.facts, raw.codes.clone()});
    return waiting_.size() < first_frames_ ? Result<void>() : start(hand_on);
  }
  TRY(expose(raw, to_seconds(raw.facts.timestamp - last_time_)));
  return hand_on(frame_);
}

Result<void> ExposedStream::finish(const HandOn& hand_on) {
  if (started_) return {};
  if (waiting_.size() < 2)
    return Error{
        ErrorCode::TooShort,
        fmt::format(
            "{} frame with a known exposure came; the method needs two or more, with different exposures",
            waiting_.empty() ? "no" : "only one")};
  return start(hand_on);
}

Result<void> ExposedStream::start(const HandOn& hand_on) {
  started_ = true;
  settings_.reference_exposure = cycle_mean(waiting_);
  for (const RawFrame& frame : waiting_) {
    if (!black_level_) black_level_ = frame.facts.black_level;
    if (white_search_) white_search_->observe(frame);
  }
  if (white_search_) settings_.white = white_search_->found();
  white_search_.reset();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const FrameFacts& frame = waiting_[i].facts;
    // no frame precedes the first one
    const Duration interval =
        i > 0 ? frame.timestamp - waiting_[i - 1].facts.timestamp : between_begins(frame, waiting_[1].facts);
    TRY(expose(waiting_[i], to_seconds(interval)));
    waiting_[i].codes = {};  // what follows takes the most memory of a run
    TRY(hand_on(frame_));
  }
  waiting_.clear();
  return {};
}

// A code above black is the same light in all frames, but where black is higher the largest code is less
// light: stretched to 255 like the others, such a frame looks as if it were exposed longer.
void ExposedStream::remove_black(const BlackLevel& own) {
  remove_black_level(frame_, own);
  frame_.exposure *= range_above(black_level_.value_or(BlackLevel())) / range_above(own);
  frame_.facts.black_level = own;
}

// Into frame_.
Result<void> ExposedStream::expose(const RawFrame& raw, double interval_s) {
  last_time_ = raw.facts.timestamp;
  StageWatch watch(timing_);
  TRY(to_exposed_frame(raw, arrived_, interval_s, settings_, frame_));
  const std::optional<BlackLevel>& own = raw.facts.black_level ? raw.facts.black_level : black_level_;
  if (own && stated_black_ == StatedBlack::Removed) remove_black(*own);
  if (is_companded_) compand(frame_);
  ++arrived_;
  watch.lap(Stage::Unpack);
  return {};
}

}  // namespace hdrcam
