#include "capture/recording_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "capture/exposure_schedule.h"

namespace hdrcam {

Result<std::unique_ptr<RecordingStage>> RecordingStage::open(Storage& storage, const std::string& path,
                                                             Contradiction contradiction,
                                                             const std::optional<BlackLevel>& black_level) {
  const Damage damage = contradiction == Contradiction::Fails ? Damage::Ends : Damage::IsSkipped;
  return std::make_unique<RecordingStage>(TRY(open_recording(storage, path, damage)), contradiction,
                                          black_level);
}

RecordingStage::RecordingStage(std::unique_ptr<RecordingReader> recording, Contradiction contradiction,
                               const std::optional<BlackLevel>& black_level)
    : recording_(std::move(recording)),
      contradiction_(contradiction),
      black_level_(black_level),
      labels_(recording_->camera(), [recording = recording_.get()](std::uint64_t sequence) {
        const std::string file = recording->file_of(sequence);
        return file.empty() ? fmt::format("frame {}", sequence)
                            : fmt::format("frame {}, '{}'", sequence, file);
      }) {}

RecordingStage::Waiting::Waiting(CapturedFrame frame) : frame_(std::move(frame)) {
  constexpr std::uint16_t kMostOfAByte = 255;
  Image<std::uint16_t>& codes = frame_.raw.codes;
  if (std::ranges::any_of(codes.samples(), [](std::uint16_t code) { return code > kMostOfAByte; })) return;
  bytes_.reshape(codes.channels(), codes.rows(), codes.cols());
  std::ranges::transform(codes.samples(), bytes_.samples().begin(),
                         [](std::uint16_t code) { return static_cast<std::uint8_t>(code); });
  codes = {};
}

CapturedFrame RecordingStage::Waiting::restored() && {
  if (!bytes_.empty()) {
    frame_.raw.codes.reshape(bytes_.channels(), bytes_.rows(), bytes_.cols());
    std::ranges::copy(bytes_.samples(), frame_.raw.codes.samples().begin());
  }
  return std::move(frame_);
}

bool RecordingStage::read(CapturedFrame& frame) {
  if (end_) return false;
  auto raw = recording_->next(std::move(frame.raw));
  if (!raw) return end_ = raw.error(), false;
  if (!raw.value()) return end_ = false, false;
  frame = {};
  frame.raw = std::move(**raw);
  if (black_level_) frame.raw.facts.black_level = black_level_;
  count_gap(frame);
  return true;
}

void RecordingStage::read_beginning() {
  begun_ = true;
  std::vector<CapturedFrame> frames;
  for (CapturedFrame frame; static_cast<int>(frames.size()) < RecordedLabels::kBeginning && read(frame);)
    frames.push_back(std::move(frame));
  labels_.judge_beginning(frames);
  for (; !frames.empty(); frames.pop_back()) beginning_.emplace_back(std::move(frames.back()));
}

Result<bool> RecordingStage::next(CapturedFrame& frame) {
  if (!begun_) read_beginning();
  if (!beginning_.empty()) {
    frame = std::move(beginning_.back()).restored();
    beginning_.pop_back();
  } else if (read(frame)) {
    labels_.judge(frame);
  } else {
    return *end_;
  }
  if (const auto objection = labels_.objection(); objection && contradiction_ == Contradiction::Fails)
    return Error{ErrorCode::BadExposure, *objection};
  ++counters_.emitted;
  compare_exposure(frame.raw.facts);
  counters_.count(frame.proof);
  return true;
}

void RecordingStage::compare_exposure(const FrameFacts& facts) {
  if (!facts.has_exposure()) return;
  ++with_exposure_;
  const Exposure exposure{from_seconds(facts.exposure_s), facts.gain()};
  if (!first_exposure_)
    first_exposure_ = exposure, relative_ = facts.exposure_source == ExposureSource::Estimated;
  exposures_differ_ =
      exposures_differ_ || !same_exposure(log_product(exposure), log_product(*first_exposure_));
}

// Of the numbers that are missing before a frame, those of damaged frames were not lost by the camera.
void RecordingStage::count_gap(CapturedFrame& frame) {
  const std::uint64_t damaged = recording_->left_out().count - left_out_;
  left_out_ += damaged;
  if (damaged > 0) frame.raw.facts.flags |= kFrameAfterDrop;
  const std::uint64_t sequence = frame.raw.facts.sequence;
  const std::uint64_t missing =
      last_sequence_ && sequence > *last_sequence_ ? sequence - *last_sequence_ - 1 : 0;
  last_sequence_ = sequence;
  constexpr std::uint64_t kMost = std::numeric_limits<int>::max();
  frame.lost_before = static_cast<int>(std::min(kMost, missing));
  counters_.lost_by_camera += missing > damaged ? missing - damaged : 0;
}

CaptureCounters RecordingStage::counters() const {
  CaptureCounters counters = counters_;
  counters.damaged = recording_->left_out().count;
  counters.captured = counters.emitted + counters.damaged;
  return counters;
}

std::vector<std::string> RecordingStage::warnings() const {
  std::vector<std::string> warnings = labels_.warnings();
  std::ranges::move(warnings_of(*recording_), std::back_inserter(warnings));
  // Contradicted exposures have their warning already, and a part of a cycle may be of equal ones.
  if (!exposures_differ_ && counters_.contradicted == 0 && with_exposure_ > ExposureSchedule::kMaxSlots)
    warnings.push_back(
        fmt::format("all {} frames have the same exposure{} and give no HDR; record a "
                    "cycle such as --shutter 1ms,4ms,16ms",
                    with_exposure_, relative_ ? "" : ", " + describe(*first_exposure_) + ","));
  return warnings;
}

}  // namespace hdrcam
