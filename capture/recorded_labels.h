// The exposures that a recording states, judged by its pictures: the same proof as on a camera
// (exposure_proof.h), with what a file allows beyond it. Its first frames are judged backwards too, from the
// frames after them, since nothing precedes them. A label that all pictures contradict is replaced where they
// agree on another of the clip's own exposures; where they do not, the frame is flagged. An exposure that the
// camera proved stays proved unless the pictures contradict it. Thread-bound.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "capture/captured_frame.h"
#include "capture/exposure_proof.h"
#include "capture/photometry.h"
#include "hal/core/frame.h"

namespace hdrcam {

class RecordedLabels {
 public:
  // Frames that are judged together: those that no full window precedes, and a window after them.
  static constexpr int kBeginning = ExposureProof::kWindow + 4;

  explicit RecordedLabels(const CameraFacts& camera);

  // The first frames of a recording, kBeginning of them or all. Once.
  void judge_beginning(std::span<CapturedFrame> frames);
  // Each frame after them, in order.
  void judge(CapturedFrame& frame);

  // What the pictures object to first: a label that was wrong, that they contradict, or that no frame can
  // have.
  std::optional<std::string> objection() const;
  // What the user should be told of the frames so far.
  std::vector<std::string> warnings() const;
  // The exposures that the labels walk through; 0 where they are too many to be a cycle.
  int slots() const { return static_cast<int>(cycle_.size()); }

 private:
  struct Label {
    double exposure_s = 0, analogue_gain = 1, digital_gain = 1;
    int slot = -1;
    double log_value() const;
  };

  // Of one kind: how many frames, and the first of them in a sentence.
  struct Objections {
    std::uint64_t count = 0;
    std::string first;

    template <class... Values>
    void object(fmt::format_string<Values...> sentence, Values&&... values) {
      if (count++ == 0) first = fmt::format(sentence, std::forward<Values>(values)...);
    }
  };

  std::optional<FrameEvidence> evidence_of(const FrameFacts& facts) const;
  void learn_cycle(const FrameFacts& facts);
  Judgement judge_forward(const CapturedFrame& frame);
  void settle(CapturedFrame& frame, const Judgement& judgement);
  void relabel(FrameFacts& facts, const Judgement& judgement);
  void check_duration(CapturedFrame& frame, std::optional<Duration> interval);
  void finish(CapturedFrame& frame, const Judgement& judgement, std::optional<Duration> interval);

  const CameraFacts camera_;
  Photometer photometer_;
  PhotometricSignature picture_;
  ExposureProof proof_;
  std::vector<Label> recent_;  // labels of the last frames
  std::vector<Label> cycle_;   // the distinct ones, at most ExposureSchedule::kMaxSlots
  std::optional<Instant> last_time_;
  std::uint64_t frames_ = 0;
  Objections relabelled_, contradicted_, overlong_;
};

}  // namespace hdrcam
