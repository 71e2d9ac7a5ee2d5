#include "capture/recording_stage.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace hdrcam {

Result<std::unique_ptr<RecordingStage>> RecordingStage::open(Storage& storage, const std::string& path,
                                                             Contradiction contradiction) {
  return std::make_unique<RecordingStage>(TRY(open_recording(storage, path)), contradiction);
}

RecordingStage::RecordingStage(std::unique_ptr<RecordingReader> recording, Contradiction contradiction)
    : recording_(std::move(recording)), contradiction_(contradiction), labels_(recording_->camera()) {}

bool RecordingStage::read(CapturedFrame& frame) {
  if (end_) return false;
  auto raw = recording_->next();
  if (!raw) return end_ = raw.error(), false;
  if (!raw.value()) return end_ = false, false;
  frame = {};
  frame.raw = std::move(**raw);
  return true;
}

void RecordingStage::read_beginning() {
  begun_ = true;
  for (CapturedFrame frame; static_cast<int>(beginning_.size()) < RecordedLabels::kBeginning && read(frame);)
    beginning_.push_back(std::move(frame));
  labels_.judge_beginning(beginning_);
  std::reverse(beginning_.begin(), beginning_.end());
}

Result<bool> RecordingStage::next(CapturedFrame& frame) {
  if (!begun_) read_beginning();
  if (!beginning_.empty()) {
    frame = std::move(beginning_.back());
    beginning_.pop_back();
  } else if (read(frame)) {
    labels_.judge(frame);
  } else {
    return *end_;
  }
  if (const auto objection = labels_.objection(); objection && contradiction_ == Contradiction::Fails)
    return Error{ErrorCode::BadExposure, *objection};
  count(frame);
  return true;
}

void RecordingStage::count(CapturedFrame& frame) {
  const std::uint64_t sequence = frame.raw.facts.sequence;
  if (last_sequence_ && sequence > *last_sequence_ + 1) {
    constexpr std::uint64_t kMost = std::numeric_limits<int>::max();
    frame.lost_before = static_cast<int>(std::min(kMost, sequence - *last_sequence_ - 1));
  }
  last_sequence_ = sequence;
  ++counters_.captured, ++counters_.emitted;
  counters_.lost_by_camera += static_cast<std::uint64_t>(frame.lost_before);
  counters_.count(frame.proof);
}

}  // namespace hdrcam
