// Which codes of two exposures are the same light, from the histograms of neighbouring frames. These show
// about the same scene, so the share q of the pixels that is darker than code z1 in one, at exposure E1, is
// darker than z2 in the other, at E2. The boundaries between codes are matched, whose place in a histogram is
// exact, not codes, which are half a step wide at worst. The codes are medians of neighbours
// (neighbour_medians.h), as noise widens a histogram and would move its quantiles. No alignment, no flow:
// matches along the flow made the response worse (docs/decisions/response.md). Where the longer exposure is
// white there is nothing to match, but its light has a lower bound; so has what is darkest an upper one.
// Thread-bound.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "capture/exposed_frame.h"
#include "online/response/smeared_white.h"

namespace hdrcam {

// Whether a pair may span a cut: then it counts only where both frames seem to show one scene (same_scene.h).
enum class SceneCuts { Possible, None };

struct CodeMatch {
  float z1, z2;  // codes of the shorter and of the longer exposure
};

// The matches of one channel for one pair of exposures.
struct CodeMatches {
  double log_ratio = 0;           // ln E1/E2 < 0, as stated; the mean, where times jitter
  float shorter = 0, longer = 0;  // E1, E2, as first stated
  int pairs = 0;                  // of frames
  int newest = 0;                 // of all pairs of frames, the last of these
  std::vector<CodeMatch> codes;
  // Codes of the shorter exposure, one of each pair of frames that tells it: of what is brighter the longer
  // exposure is white.
  std::vector<float> white_from;
  // Likewise, at the other end: hardly anything is below this code of the shorter exposure, and what is at it
  // is not brighter than this code of the longer one.
  std::vector<CodeMatch> dark_to;
};

class HistogramMatches {
 public:
  static constexpr int kQuantiles = 400;         // matches per pair and channel
  static constexpr std::size_t kMostPairs = 64;  // of exposures: the newest, where they go on changing

  // Of one channel, by the stated exposures, shorter and longer (ExposureCorrections::key).
  using OfChannel = std::map<std::pair<int, int>, CodeMatches>;

  // Adds the matches of two frames of different exposure, as the estimator has them. It skips frames of
  // (nearly) the same exposure, of unproved exposure, or of different scenes (a cut), and finds none in
  // frames that show nothing; returns whether the pair counted.
  bool add(const ExposedFrame& a, const ExposedFrame& b, SceneCuts cuts);

  // Those that counted; one that tells where white begins, and matches no code, does, too: how little that
  // says of the curve the curve's uncertainty tells.
  int pairs() const { return pairs_; }
  // channel: R G B.
  const OfChannel& of(std::size_t channel) const { return matches_[channel]; }
  // All exposures that occur, ascending (ExposureCorrections::key).
  std::vector<int> exposure_keys() const;
  // The same, by key, as they were stated.
  std::map<int, float> exposures() const;

  // Codes of the shortest exposure, bounds of a black level: hardly a pixel is darker than the first; noise
  // and compression may have put a tenth of the pixels below black, not more.
  float darkest(std::size_t channel) const { return darkest_[channel]; }
  float most_black(std::size_t channel) const { return most_black_[channel]; }

  const SmearedWhite& smeared_white(std::size_t channel) const { return smeared_white_[channel]; }

 private:
  struct OfFrames {  // of a channel
    std::vector<CodeMatch> codes;
    std::optional<float> white_from;   // CodeMatches
    std::optional<CodeMatch> dark_to;  // likewise

    bool empty() const { return codes.empty() && !white_from; }
  };
  using OfPair = std::array<OfFrames, 3>;  // of the channels
  // What a frame does to the bounds of the black level: the shortest exposure tells them.
  enum class BlackBounds { Kept, Widened, Anew };

  // Of the codes of two frames, in any order; scratch: room for sorting, which one pair needs six times.
  static OfFrames matches_between(std::vector<float> shorter, std::vector<float> longer,
                                  std::vector<float>& scratch);
  // Takes the bounds of the black level from the shorter frame, too.
  OfPair match(const ExposedFrame& shorter, const ExposedFrame& longer);
  BlackBounds bounds_by(float exposure);
  // codes: all of the shorter frame that are looked at.
  void bound_black(std::size_t channel, std::vector<float> codes, BlackBounds bounds);
  void keep(const OfPair& found, float shorter, float longer);  // exposures

  int pairs_ = 0;
  std::optional<float> shortest_;  // exposure
  std::array<float, 3> darkest_{}, most_black_{};
  std::array<SmearedWhite, 3> smeared_white_;
  std::array<OfChannel, 3> matches_;
};

}  // namespace hdrcam
