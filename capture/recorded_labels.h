// Judges the exposures that a recording states by its pictures, with the same proof as on a camera
// (exposure_proof.h) and with two things that only a file allows. The first frames are judged backward as
// well, from the frames after them, since none precede them. A label that all pictures contradict is replaced
// where they agree on another of the clip's own exposures; otherwise the frame is flagged. An exposure
// that was proved on the camera stays proved unless the pictures contradict it. Exposures that were estimated
// from the pictures are at best estimated, labels that the pictures gave a frame plausible: pictures do not
// prove what was taken from them. Where neighbours have nothing in common that a ratio could be taken of,
// there is an objection only if many of them are darker though their labels say that they should be brighter,
// or the reverse. Thread-bound.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "capture/captured_frame.h"
#include "capture/exposure_proof.h"
#include "capture/order_check.h"
#include "capture/photometry.h"
#include "hal/core/frame.h"
#include "hal/core/white_level.h"

namespace hdrcam {

class RecordedLabels {
 public:
  // First frames, judged together: those without a full window before them, and a window after them.
  static constexpr int kBeginning = ExposureProof::kWindow + 4;

  // For people, by its number: "frame 3", with its file where it has one of its own.
  using FrameName = std::function<std::string(std::uint64_t sequence)>;

  RecordedLabels(const CameraFacts& camera, FrameName name_of);

  // Judges the first kBeginning frames of a recording, or all if there are fewer. Called once.
  void judge_beginning(std::span<CapturedFrame> frames);
  // Judges each later frame, in order.
  void judge(CapturedFrame& frame);

  // The first objection: a label that was wrong, that the pictures contradict, or that no frame can have.
  std::optional<std::string> objection() const;
  // Warnings for the user about the frames so far.
  std::vector<std::string> warnings() const;
  // Number of distinct exposures among the labels; 0 where there are too many for a cycle.
  int slots() const { return static_cast<int>(cycle_.size()); }

 private:
  struct Label {
    double exposure_s = 0, analogue_gain = 1, digital_gain = 1;
    int slot = -1;
    bool estimated = false;
    double log_value() const;
  };

  // The objections of one kind: how many frames, and a sentence about the first.
  struct Objections {
    std::uint64_t count = 0;
    std::string first;

    template <class... Values>
    void object(const FrameName& name_of, std::uint64_t sequence, fmt::format_string<Values...> sentence,
                Values&&... values) {
      if (count++ == 0)
        first = name_of(sequence) + ": " + fmt::format(sentence, std::forward<Values>(values)...);
    }
  };

  static Label label_of(const FrameFacts& facts);
  std::string described(const Label& label) const;
  std::optional<FrameEvidence> evidence_of(const FrameFacts& facts) const;
  void learn_cycle(const FrameFacts& facts);
  void look_at(const RawFrame& raw);
  Judgement judge_forward(const CapturedFrame& frame);
  void settle(CapturedFrame& frame, const Judgement& judgement);
  void relabel(FrameFacts& facts, const Judgement& judgement);
  void check_order(const FrameFacts& facts);
  void check_duration(CapturedFrame& frame, std::optional<Duration> interval);
  void finish(CapturedFrame& frame, const Judgement& judgement, std::optional<Duration> interval);

  const CameraFacts camera_;
  const FrameName name_of_;
  std::optional<BlackLevel> black_level_;  // of frames that state none: the first stated
  WhiteLevel white_level_;                 // as the first frames show it
  Photometer photometer_;
  PhotometricSignature picture_;
  std::optional<Exposure> last_exposure_;  // of the frame before, where it was judged and has a label
  ExposureProof proof_;
  std::vector<Label> recent_;  // labels of the last frames
  std::vector<Label> cycle_;   // the distinct ones, at most ExposureSchedule::kMaxSlots
  std::optional<Instant> last_time_;
  std::uint64_t frames_ = 0;
  OrderCheck order_;
  Objections relabelled_, contradicted_, out_of_order_, overlong_;
};

}  // namespace hdrcam
