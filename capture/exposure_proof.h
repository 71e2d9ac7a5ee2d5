// Which exposure a frame really has, and how sure that is. Whoever reports or predicts an exposure makes a
// claim; the proof weighs claims against witnesses that do not depend on them: the pictures, and the strobe.
//
//   claims      embedded in the frame by the sensor, reported by the driver, predicted from what was asked
//   witnesses   ratios between the pictures of the last eight frames (photometry.h), the strobe's width
//
// 1. The pictures alone are asked which exposures of the cycle explain them. Every assignment of exposures
//    to the last eight frames that lies within all measured ratios is an explanation; a frame that fits none
//    is called odd and left out, at a cost of one. The newest frame's exposure is *unique* when every
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
//    not unique, claims disagree, or the best
//      is a doubtful prediction                  -> unknown
//    not unique, nothing contradicts             -> plausible
// 3. Contradicted and unknown frames are flagged (kFrameExposureUnproved) and keep out of the fit.
//
// What is proved: the product time x gain, relative to the frames around it, to within `within_ev`. Pictures
// know no absolute scale; it is that of the claims, and without effect on relative radiance. A cycle of one
// exposure proves nothing by pictures: there a frame is proved only by the strobe or by the sensor's embedded
// data. Thread-bound; bounded state, no allocation.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "capture/exposure.h"
#include "capture/photometry.h"

namespace hdrcam {

struct ExposureClaim {
  Exposure exposure;
  double digital_gain = 1;
  ExposureSource source = ExposureSource::Unknown;

  double log_value() const;  // ln of the product of all three
};

// What is said and seen of one frame, besides its picture. Claims best first.
struct FrameEvidence {
  static constexpr int kMaxClaims = 3;
  std::array<ExposureClaim, kMaxClaims> claims{};
  int claim_count = 0;
  bool prediction_doubtful = false;      // the controls of this frame were written late
  std::optional<Duration> strobe_width;  // as measured; only where the pulse is as long as the exposure

  void add(const ExposureClaim& claim) { claims[static_cast<std::size_t>(claim_count++)] = claim; }
};

struct Judgement {
  Verdict verdict = Verdict::Unknown;
  ExposureClaim label;  // the exposure that the frame is taken to have; source Unknown where there is none
  bool relabelled = false;       // by the pictures, against all claims
  double within_ev = 0;          // of a proved label, stops: what the witnesses leave open
  std::optional<double> unique;  // ln E that only the pictures and the strobe say, where they are unanimous

  bool trusted() const { return verdict == Verdict::Proved || verdict == Verdict::Plausible; }
};

class ExposureProof {
 public:
  static constexpr int kWindow = 8;      // frames: two rounds of the longest cycle
  static constexpr int kCandidates = 8;  // exposures: a cycle of four, and the cycle before it
  static constexpr double kSame = kSameExposure;

  // The exposures that frames can have. After a change of schedule the earlier ones stay candidates, as
  // frames under way still have them, until enough frames are proved to have the new ones.
  void set_cycle(std::span<const Exposure> cycle);
  // All that earlier frames said is void: another response, a restarted camera.
  void forget() { count_ = 0; }

  // The next frame, with its picture. Frames whose pixels are damaged do not come here.
  Judgement judge(const FrameEvidence& evidence, const PhotometricSignature& picture, Photometer& photometer);

 private:
  static constexpr int kValues = kCandidates + 1;  // and what a claim says beyond the cycle
  struct Frame {
    PhotometricSignature picture;
    std::array<std::optional<PhotometricRatio>, kWindow>
        ratio_from;                        // [k]: from the frame k + 1 before this one
    std::array<double, kValues> values{};  // ln E that it can have
    int value_count = 0;
    Judgement judgement;
  };
  // How many of the frames must be odd if the newest has exposure `value`; kNever where that cannot be.
  struct Explanations {
    std::array<int, kValues> odd_if{};
    int odd_if_newest_is_odd = 0;
    int fewest_odd = kNever;
    std::optional<int> unique;  // index into the newest frame's values
    bool fits_nothing = false;  // the newest frame is the odd one
  };
  static constexpr int kNever = kWindow + 1;

  Frame& back(int age) { return ring_[static_cast<std::size_t>((newest_ + kWindow - age) % kWindow)]; }
  const Frame& back(int age) const {
    return ring_[static_cast<std::size_t>((newest_ + kWindow - age) % kWindow)];
  }

  void gather_values(const FrameEvidence& evidence, Frame& frame) const;
  Explanations explain() const;
  int fewest_odd(int age, int odd, int bound, std::array<double, kWindow>& assigned) const;
  bool fits(int age, double value, const std::array<double, kWindow>& assigned) const;
  struct Votes {
    int against = 0, in_favour = 0;
  };
  Votes neighbours_on(double claimed) const;
  bool another_explains_better(double claimed, const Explanations& explanations) const;
  double open_interval_ev(double label) const;
  Judgement weigh(const FrameEvidence& evidence, const Explanations& explanations) const;
  Judgement unique_judgement(const FrameEvidence& evidence, double value) const;
  void retire_earlier_cycle(const Judgement& judgement);

  std::array<Exposure, kCandidates> cycle_{};  // the current one first, then the one before
  int current_count_ = 0, cycle_count_ = 0;
  bool told_apart_ = false;  // the current cycle has two exposures that differ
  int proved_in_current_ = 0;
  std::array<Frame, kWindow> ring_{};
  int newest_ = 0, count_ = 0;
};

}  // namespace hdrcam
