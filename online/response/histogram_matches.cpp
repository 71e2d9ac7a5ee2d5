#include "online/response/histogram_matches.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "capture/clip_policy.h"
#include "online/pictures/same_scene.h"
#include "online/pictures/sparse_lines.h"
#include "online/response/blur_between.h"
#include "online/response/exposure_corrections.h"
#include "online/response/float_order.h"
#include "online/response/sparse_channel.h"

namespace hdrcam {
namespace {

constexpr clip_policy::UsableCodes kUsable = clip_policy::kResponseMatch;
constexpr double kDarkShare = 0.0005;  // of the pixels
constexpr double kBelowBlack = 0.1;    // of the pixels, at most: by noise and compression

// Of the pixels, those that are neither black in the shorter nor white in the longer frame; below 0: none.
double share_in_both(const SparseChannel& shorter, const SparseChannel& longer) {
  const auto black = shorter.count([](float code) { return code < kUsable.darkest; });
  const auto seen = longer.count([](float code) { return code <= kUsable.brightest; });
  return static_cast<double>(seen - black) / static_cast<double>(longer.pixels());
}

// The code of unsorted pixels that has the rank of this share in a Ranking; puts them into another order.
float unsorted_code_at(std::vector<float>& codes, double share) {
  const auto index = static_cast<std::size_t>(share * static_cast<double>(codes.size()));
  const auto at = codes.begin() + static_cast<std::ptrdiff_t>(std::min(codes.size() - 1, index));
  std::nth_element(codes.begin(), at, codes.end());
  return *at;
}

// Codes in order, which know their place in the histogram.
class Ranking {
 public:
  Ranking(std::vector<float> codes, std::vector<float>& scratch) : codes_(std::move(codes)) {
    sort_floats(codes_, scratch);
  }

  struct Boundary {
    double code;   // midway between two neighbouring codes
    double share;  // of the pixels that are darker
  };
  // The boundary between codes that is nearest to this share of the pixels; none across a gap. Where there is
  // but one code, that code.
  std::optional<Boundary> boundary_near(double share) const {
    const Plateau p = plateau(share);
    if (is_all(p)) return Boundary{p.code, share};
    const double below = static_cast<double>(p.begin) / size(), above = static_cast<double>(p.end) / size();
    const bool lower = share - below < above - share;
    const double code = lower ? p.lower : p.upper;
    if (std::abs(code - p.code) > kWidestGap / 2) return std::nullopt;
    return Boundary{code, lower ? below : above};
  }
  // The code below which this share of the pixels lies, linear within one code; none where it is white.
  std::optional<double> code_at(double share) const {
    const Plateau p = plateau(share);
    if (p.code > static_cast<double>(kUsable.brightest)) return std::nullopt;
    const double within =
        (share * size() - static_cast<double>(p.begin)) / static_cast<double>(p.end - p.begin);
    const double lower = std::max(p.lower, p.code - kWidestGap / 2),
                 upper = std::min(p.upper, p.code + kWidestGap / 2);
    return lower + (upper - lower) * std::clamp(within, 0.0, 1.0);
  }
  bool has_one_code() const { return is_all(plateau(0.5)); }
  // The boundaries between codes below and above what has the rank of this share.
  double code_below(double share) const { return plateau(share).lower; }
  double code_above(double share) const { return plateau(share).upper; }
  double share_of_white() const {
    const auto white = std::upper_bound(codes_.begin(), codes_.end(), kUsable.brightest);
    return static_cast<double>(codes_.end() - white) / size();
  }

 private:
  // codes that no pixel has, between two that are neighbours: light that the scene has not, wherever in the
  // gap of the other frame it would be
  static constexpr double kWidestGap = 8;

  struct Plateau {
    std::size_t begin, end;     // the pixels of one code
    double code, lower, upper;  // its boundaries are midway to its neighbours
  };
  Plateau plateau(double share) const {
    const float code = codes_[index(share)];
    const auto [first, last] = std::equal_range(codes_.begin(), codes_.end(), code);
    const auto z = static_cast<double>(code);
    const double lower = first == codes_.begin() ? z - 0.5 : (z + static_cast<double>(*std::prev(first))) / 2;
    const double upper = last == codes_.end() ? z + 0.5 : (z + static_cast<double>(*last)) / 2;
    return {static_cast<std::size_t>(first - codes_.begin()), static_cast<std::size_t>(last - codes_.begin()),
            z, lower, upper};
  }
  // But for a few pixels.
  bool is_all(const Plateau& p) const {
    return static_cast<double>(p.end - p.begin) >= (1 - kDarkShare) * size();
  }
  std::size_t index(double share) const {
    return std::min(codes_.size() - 1, static_cast<std::size_t>(share * size()));
  }
  double size() const { return static_cast<double>(codes_.size()); }

  std::vector<float> codes_;
};

// Where medians leave less than half of what both frames show, it was small lights, not noise, that they took
// away.
constexpr double kEnough = 0.5;

std::ptrdiff_t usable(const std::vector<CodeMatch>& matches) {
  return std::ranges::count_if(matches, [](const CodeMatch& match) {
    return match.z1 >= kUsable.darkest && match.z2 <= kUsable.brightest;
  });
}

bool too_few(const std::vector<CodeMatch>& matches, double expected) {
  return static_cast<double>(usable(matches)) < kEnough * expected;
}

// Of a stream that goes on.
constexpr std::size_t kMostFrames = 25;  // pairs of them

template <class Found>
void keep_newest(std::vector<Found>& found, std::size_t most) {
  if (found.size() > most) found.erase(found.begin(), found.end() - static_cast<std::ptrdiff_t>(most));
}

void keep_newest(HistogramMatches::OfChannel& matches) {
  if (matches.size() > HistogramMatches::kMostPairs)
    matches.erase(
        std::ranges::min_element(matches, {}, [](const auto& entry) { return entry.second.newest; }));
}

constexpr double kMoved = 0.02;  // of the pixels: motion between frames moves shares

// Codes of `dark` from which on `light` is white; none where white, or all else, is hardly seen: motion
// between the frames moves shares.
std::optional<float> first_white(const Ranking& dark, const Ranking& light) {
  const double white = light.share_of_white();
  if (white < 2 * kMoved || white > 1 - kMoved) return std::nullopt;
  const auto code = static_cast<float>(dark.code_above(1 - white + kMoved));
  return code <= kUsable.brightest ? std::optional(code) : std::nullopt;
}

// The code of `dark` below which hardly anything is, and the one of `light` that is as dark at most. None
// where the shorter exposure is bright, or the longer one: white that is smeared is no measure.
std::optional<CodeMatch> first_dark(const Ranking& dark, const Ranking& light) {
  constexpr double kHighest = 24, kBright = 127;  // codes
  const double code = dark.code_below(kMoved);
  const std::optional<double> other = light.code_at(2 * kMoved);
  if (code < kUsable.darkest || code > kHighest || !other || *other > kBright) return std::nullopt;
  return CodeMatch{static_cast<float>(code), static_cast<float>(*other)};
}

}  // namespace

bool HistogramMatches::add(const ExposedFrame& a, const ExposedFrame& b, SceneCuts cuts) {
  constexpr double kMinRatio = 1.15;  // of exposures: below it a pair does not constrain the curve
  const ExposedFrame& shorter = a.exposure <= b.exposure ? a : b;
  const ExposedFrame& longer = &shorter == &a ? b : a;
  if (longer.exposure < static_cast<float>(kMinRatio) * shorter.exposure) return false;
  if (((a.facts.flags | b.facts.flags) & (kFrameExposureUnproved | kFrameDamaged)) != 0) return false;
  if (cuts == SceneCuts::Possible && !shows_one_scene(a, b)) return false;
  const OfPair found = match(shorter, longer);
  if (std::ranges::all_of(found, &OfFrames::empty)) return false;
  keep(found, shorter.exposure, longer.exposure);
  return true;
}

HistogramMatches::OfFrames HistogramMatches::matches_between(std::vector<float> shorter,
                                                             std::vector<float> longer,
                                                             std::vector<float>& scratch) {
  const Ranking dark(std::move(shorter), scratch), light(std::move(longer), scratch);
  OfFrames found{{}, first_white(dark, light), first_dark(dark, light)};
  if (light.has_one_code()) return found;
  // of a shorter exposure of one code the longer one tells what is black: all that it does not make brighter
  for (int q = 1; q < kQuantiles; ++q) {
    const auto boundary = dark.boundary_near(static_cast<double>(q) / kQuantiles);
    if (!boundary || boundary->share <= kDarkShare || boundary->share >= 1 - kDarkShare) continue;
    const std::optional<double> other = light.code_at(boundary->share);
    if (other && *other >= boundary->code)
      found.codes.push_back({static_cast<float>(boundary->code), static_cast<float>(*other)});
  }
  return found;
}

HistogramMatches::OfPair HistogramMatches::match(const ExposedFrame& shorter, const ExposedFrame& longer) {
  const BlackBounds bounds = bounds_by(shorter.exposure);
  const BlurLengths blur = blur_between(shorter.codes, longer.codes);
  const int step = line_step(longer.codes);
  Image<float> blurred;
  std::vector<float> scratch;
  OfPair found;
  for (std::size_t c = 0; c < 3; ++c) {
    const int channel = static_cast<int>(c);
    if (blur.any()) blur_channel(shorter.codes, channel, blur, blurred);
    const SparseChannel dark =
        blur.any() ? SparseChannel{blurred, 0, step} : SparseChannel{shorter.codes, channel, step};
    const SparseChannel light{longer.codes, channel, step};
    smeared_white_[c].add({shorter.codes, channel, step}, light);
    if (bounds != BlackBounds::Kept) bound_black(c, dark.plain_codes(), bounds);
    found[c] = matches_between(dark.median_codes(), light.median_codes(), scratch);
    if (!too_few(found[c].codes, share_in_both(dark, light) * kQuantiles)) continue;
    OfFrames plain = matches_between(dark.plain_codes(), light.plain_codes(), scratch);
    if (too_few(found[c].codes, static_cast<double>(usable(plain.codes)))) found[c] = std::move(plain);
  }
  return found;
}

void HistogramMatches::bound_black(std::size_t channel, std::vector<float> codes, BlackBounds bounds) {
  const float darkest = unsorted_code_at(codes, kDarkShare), most = unsorted_code_at(codes, kBelowBlack);
  const bool anew = bounds == BlackBounds::Anew;
  darkest_[channel] = anew ? darkest : std::min(darkest_[channel], darkest);
  most_black_[channel] = anew ? most : std::min(most_black_[channel], most);
}

HistogramMatches::BlackBounds HistogramMatches::bounds_by(float exposure) {
  constexpr float kShorter = 0.9f, kAlike = 1.1f;  // over the shortest exposure, whose reported times jitter
  if (!shortest_ || exposure < kShorter * *shortest_) {
    shortest_ = exposure;
    return BlackBounds::Anew;
  }
  return exposure < kAlike * *shortest_ ? BlackBounds::Widened : BlackBounds::Kept;
}

void HistogramMatches::keep(const OfPair& found, float shorter, float longer) {
  const std::pair key{ExposureCorrections::key(shorter), ExposureCorrections::key(longer)};
  const double log_ratio = std::log(static_cast<double>(shorter) / static_cast<double>(longer));
  for (std::size_t c = 0; c < 3; ++c) {
    CodeMatches& matches = matches_[c][key];
    if (matches.pairs == 0) matches.shorter = shorter, matches.longer = longer;
    matches.log_ratio += (log_ratio - matches.log_ratio) / ++matches.pairs;
    matches.codes.insert(matches.codes.end(), found[c].codes.begin(), found[c].codes.end());
    if (found[c].white_from) matches.white_from.push_back(*found[c].white_from);
    keep_newest(matches.codes, kMostFrames * kQuantiles);
    if (found[c].dark_to) matches.dark_to.push_back(*found[c].dark_to);
    keep_newest(matches.white_from, kMostFrames);
    keep_newest(matches.dark_to, kMostFrames);
    matches.newest = pairs_;
    keep_newest(matches_[c]);
  }
  ++pairs_;
}

std::vector<int> HistogramMatches::exposure_keys() const {
  std::vector<int> keys;
  for (const auto& [pair, matches] : matches_[0]) keys.push_back(pair.first), keys.push_back(pair.second);
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

std::map<int, float> HistogramMatches::exposures() const {
  std::map<int, float> exposures;
  for (const auto& [pair, matches] : matches_[0]) {
    exposures.try_emplace(pair.first, matches.shorter);
    exposures.try_emplace(pair.second, matches.longer);
  }
  return exposures;
}

}  // namespace hdrcam
