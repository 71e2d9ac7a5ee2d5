// Decides which exposure a frame really has, and how certain that is. A reported or predicted exposure is a
// claim; the proof weighs claims against witnesses that do not depend on them: the pictures and the strobe.
//
//     claims      embedded in the frame by the sensor, reported by the driver, predicted from the requests
//   witnesses   ratios between the pictures of the last eight frames (photometry.h), the strobe's width
//
// 1. First the pictures alone decide which exposures of the cycle explain them. Every assignment of exposures
//    to the last eight frames that lies within all measured ratios is an explanation; a frame that fits none
//    is an outlier and is left out, at a cost of one. The newest frame's exposure is *unique* when every
//    explanation with another exposure costs two more: two witnesses would have to be wrong together. One
//    ratio of 4 fits two places of a cycle 1:4:16; the next ratio settles it, which is why a cycle proves
//    itself within about one round. Frames already proved keep their exposure in every explanation.
// 2. unique, and the best claim says the same    -> proved
//    unique, and another claim says the same     -> plausible, labelled by that claim
//    unique, and no claim says the same          -> plausible, relabelled by the pictures (Photometric)
//    not unique, no claim                        -> unknown
//    not unique, and the frame fits nothing, or
//      its claim contradicts the ratios to its
//      neighbours at least as often as it agrees,
//      or another exposure explains them better  -> contradicted
//      but where the pictures differ no more than
//      the light of lamps on the mains does, and
//      the claim is stronger than a prediction   -> plausible
//    not unique, claims disagree, or the best
//      is a doubtful prediction                  -> unknown
//    not unique, nothing contradicts             -> plausible
//    A strobe pulse that is not as long as the sensor itself says in this frame does not count: it is another
//    frame's, or no exposure at all. Against every other claim it does.
//    A strobe shows time, not gain. Where the gains of the cycle differ, a frame with a pulse is unique only
//    if each time with the gain of another slot, as many slots away for all frames (a control delay that is
//    wrong for one of the two), costs two more as well; contradicted if that explains the pictures better.
// 3. Contradicted and unknown frames are flagged (kFrameExposureUnproved) and are kept out of the fit.
//
// The proof covers the product time x gain, relative to the neighbouring frames, to within `within_ev`.
// Pictures carry no absolute scale: the claims set it, and it does not change relative radiance. In a cycle
// of one exposure pictures prove nothing; only the strobe or the sensor's embedded data proves a frame there.
// Where no cycle is known, as of a recording with more than four exposures, nothing proves one. Thread-bound;
// bounded state, no allocation.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "capture/exposure.h"
#include "capture/photometry.h"
#include "hal/core/inline_list.h"

namespace hdrcam {

struct ExposureClaim {
  Exposure exposure;
  double digital_gain = 1;
  ExposureSource source = ExposureSource::Unknown;

  double log_value() const;  // ln of the product of all three
};

// The evidence about one frame besides its picture.
struct FrameEvidence {
  InlineList<ExposureClaim, 3> claims;   // the best one first
  bool prediction_doubtful = false;      // the controls of this frame were written late
  std::optional<Duration> strobe_width;  // as measured; only where the pulse is as long as the exposure
  std::optional<Duration> pulse_within;  // uncertainty of a claim that is the width of the trigger's pulse
};

struct Judgement {
  Verdict verdict = Verdict::Unknown;
  ExposureClaim label;           // the exposure assigned to the frame; source Unknown where there is none
  bool relabelled = false;       // by the pictures, against all claims
  double within_ev = 0;          // remaining uncertainty of a proved label, stops
  std::optional<double> unique;  // ln E from pictures and strobe alone, where they are unanimous
  bool strobe_refuses = false;   // the width of the strobe's pulse: the best claim
  bool as_by_light = false;      // the pictures differ by no more than the light of lamps changes

  bool trusted() const {
    return verdict == Verdict::Proved || verdict == Verdict::Plausible || verdict == Verdict::Estimated;
  }
  // Pictures do not prove an exposure that was taken from them.
  void limit_to(ExposureSource stated) {
    if (stated == ExposureSource::Estimated && trusted()) verdict = Verdict::Estimated;
    if (stated == ExposureSource::Photometric && verdict == Verdict::Proved) verdict = Verdict::Plausible;
  }
};

class ExposureProof {
 public:
  static constexpr int kWindow = 8;               // frames: two rounds of the longest cycle
  static constexpr std::size_t kCandidates = 12;  // exposures: a cycle of four, and the two before it

  // Sets the exposures that frames can have. After a change of schedule those of the last two stay
  // candidates, because queued requests still carry them, until enough frames are proved to have the new
  // ones, or pictures leave so many in a row open that no request can carry the earlier ones any more.
  void set_cycle(std::span<const Exposure> cycle);
  // For a cycle that is learned from labels: undecided frames before it was known may have its exposures,
  // too.
  void widen_undecided();
  // Discards the evidence of earlier frames: after a new response or a restart of the camera.
  void forget() { count_ = 0; }

  // Judges the next frame by its picture. The caller leaves out frames whose pixels are damaged.
  Judgement judge(const FrameEvidence& evidence, const PhotometricSignature& picture, Photometer& photometer);
  // The picture before the newest one, where no ratio could be taken of the two; else null.
  const PhotometricSignature* incomparable_previous() const {
    return count_ > 1 && !back(0).ratio_from[0] ? &back(1).picture : nullptr;
  }

 private:
  using Candidates = InlineList<Exposure, kCandidates>;
  static constexpr std::size_t kValues = kCandidates + 1;  // and a claim outside the cycle
  struct Frame {
    PhotometricSignature picture;
    // [k]: from the frame k + 1 before this one.
    std::array<std::optional<PhotometricRatio>, kWindow> ratio_from;
    InlineList<double, kValues> values;  // ln E that it can have
    Judgement judgement;
  };
  struct Explanations {
    // outliers_if[i]: frames that must be outliers if the newest has its value i; kNever where that is
    // impossible.
    std::array<int, kValues> outliers_if{};
    int outliers_if_newest_is_one = 0;
    int fewest_outliers = kNever;
    std::optional<std::size_t> unique;  // index into the newest frame's values
    bool fits_nothing = false;          // the newest frame is the outlier
    bool other_gains_fit_better = false;
  };
  static constexpr int kNever = kWindow + 1, kMostOutliers = 2, kMargin = 2;
  static constexpr int kBound = kMostOutliers + kMargin + 1;  // higher costs are all alike

  Frame& back(std::size_t age) { return ring_[(newest_ + kWindow - age) % kWindow]; }
  const Frame& back(std::size_t age) const { return ring_[(newest_ + kWindow - age) % kWindow]; }

  std::span<const Exposure> all_candidates() const { return candidates_; }
  std::span<const Exposure> current_cycle() const { return all_candidates().first(current_count_); }

  void gather_values(const FrameEvidence& evidence, Frame& frame) const;
  // time_alone: a strobe chose among the candidates, which shows no gain.
  Explanations explain(bool time_alone) const;
  InlineList<double, kCandidates> with_gain_of(std::size_t shift, double value) const;
  int fewest_outliers(std::size_t age, int outliers, int bound, std::size_t shift,
                      std::array<double, kWindow>& assigned) const;
  int fewest_with_other_gains(double value) const;
  bool fits(std::size_t age, double value, const std::array<double, kWindow>& assigned) const;
  struct Votes {
    int against = 0, in_favour = 0;
  };
  Votes neighbours_on(double claimed) const;
  bool another_explains_better(double claimed, const Explanations& explanations) const;
  bool differs_as_by_light(double claimed) const;
  bool outweighs_light(ExposureSource source) const;
  double open_interval_ev(double label) const;
  Judgement weigh(const FrameEvidence& evidence, const Explanations& explanations) const;
  Judgement unique_judgement(const FrameEvidence& evidence, double value) const;
  void retire_earlier_cycles(const FrameEvidence& evidence, const Judgement& judgement);

  Candidates candidates_;          // the current cycle, then those before
  std::size_t current_count_ = 0;  // of the current cycle
  bool exposures_differ_ = false;  // the current cycle has two exposures that differ
  int proved_in_current_ = 0;
  int undecided_ = 0;  // frames in a row, while earlier cycles are candidates
  // Since the last change a picture showed an earlier exposure where the best claim was of the current cycle:
  // the camera may ignore the change, and claims alone do not end the earlier cycle.
  bool change_denied_ = false;
  std::array<Frame, kWindow> ring_{};
  std::size_t newest_ = 0, count_ = 0;
};

}  // namespace hdrcam
