#include "online/response/histogram_matches.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "online/pictures/same_scene.h"
#include "online/pictures/sparse_lines.h"
#include "online/response/blur_between.h"
#include "online/response/exposure_corrections.h"
#include "online/response/float_order.h"

namespace hdrcam {
namespace {

constexpr double kDarkShare = 0.0005;  // of the pixels
constexpr double kBelowBlack = 0.1;    // of the pixels, at most: by noise and compression

// A sorted channel that gives the place of its codes in the histogram.
class Ranking {
 public:
  Ranking(const Image<float>& codes, int channel, std::vector<float>& scratch) {
    const int step = line_step(codes);
    codes_.reserve(codes.plane_size() / static_cast<std::size_t>(step) +
                   static_cast<std::size_t>(codes.cols()));
    for (int y = 0; y < codes.rows(); y += step)
      codes_.insert(codes_.end(), codes.row(channel, y), codes.row(channel, y) + codes.cols());
    sort_floats(codes_, scratch);
  }

  struct Boundary {
    double code;   // midway between two neighbouring codes
    double share;  // of the pixels that are darker
  };
  // The boundary between codes that is nearest to this share of the pixels.
  Boundary boundary_near(double share) const {
    const Plateau p = plateau(share);
    const double below = static_cast<double>(p.begin) / size(), above = static_cast<double>(p.end) / size();
    return share - below < above - share ? Boundary{p.lower, below} : Boundary{p.upper, above};
  }
  // The code below which this share of the pixels lies, linear within one code.
  double code_at(double share) const {
    const Plateau p = plateau(share);
    const double within =
        (share * size() - static_cast<double>(p.begin)) / static_cast<double>(p.end - p.begin);
    return p.lower + (p.upper - p.lower) * std::clamp(within, 0.0, 1.0);
  }
  float quantile(double share) const { return codes_[index(share)]; }

 private:
  struct Plateau {
    std::size_t begin, end;  // the pixels of one code
    double lower, upper;     // its boundaries
  };
  Plateau plateau(double share) const {
    const float code = codes_[index(share)];
    const auto [first, last] = std::equal_range(codes_.begin(), codes_.end(), code);
    const auto z = static_cast<double>(code);
    const double lower = first == codes_.begin() ? z - 0.5 : (z + static_cast<double>(*std::prev(first))) / 2;
    const double upper = last == codes_.end() ? z + 0.5 : (z + static_cast<double>(*last)) / 2;
    return {static_cast<std::size_t>(first - codes_.begin()), static_cast<std::size_t>(last - codes_.begin()),
            lower, upper};
  }
  std::size_t index(double share) const {
    return std::min(codes_.size() - 1, static_cast<std::size_t>(share * size()));
  }
  double size() const { return static_cast<double>(codes_.size()); }

  std::vector<float> codes_;
};

// Of a stream that goes on.
void keep_newest(std::vector<CodeMatch>& matches) {
  constexpr std::size_t kMost = 25 * std::size_t{HistogramMatches::kQuantiles};
  if (matches.size() > kMost)
    matches.erase(matches.begin(), matches.end() - static_cast<std::ptrdiff_t>(kMost));
}

void keep_newest(HistogramMatches::OfChannel& matches) {
  if (matches.size() > HistogramMatches::kMostPairs)
    matches.erase(
        std::ranges::min_element(matches, {}, [](const auto& entry) { return entry.second.newest; }));
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
  if (std::ranges::all_of(found, &std::vector<CodeMatch>::empty)) return false;
  keep(found, shorter.exposure, longer.exposure);
  return true;
}

HistogramMatches::OfPair HistogramMatches::match(const ExposedFrame& shorter, const ExposedFrame& longer) {
  const BlackBounds bounds = bounds_by(shorter.exposure);
  const BlurLengths blur = blur_between(shorter.codes, longer.codes);
  Image<float> blurred;
  std::vector<float> scratch;
  OfPair found;
  for (std::size_t c = 0; c < 3; ++c) {
    const int channel = static_cast<int>(c);
    if (blur.any()) blur_channel(shorter.codes, channel, blur, blurred);
    const Ranking dark(blur.any() ? blurred : shorter.codes, blur.any() ? 0 : channel, scratch),
        light(longer.codes, channel, scratch);
    if (bounds != BlackBounds::Kept) {
      const float darkest = dark.quantile(kDarkShare), most = dark.quantile(kBelowBlack);
      const bool anew = bounds == BlackBounds::Anew;
      darkest_[c] = anew ? darkest : std::min(darkest_[c], darkest);
      most_black_[c] = anew ? most : std::min(most_black_[c], most);
    }
    for (int q = 1; q < kQuantiles; ++q) {
      const auto [code, share] = dark.boundary_near(static_cast<double>(q) / kQuantiles);
      if (share <= kDarkShare || share >= 1 - kDarkShare) continue;
      const double other = light.code_at(share);
      if (other >= code) found[c].push_back({static_cast<float>(code), static_cast<float>(other)});
    }
  }
  return found;
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
    matches.codes.insert(matches.codes.end(), found[c].begin(), found[c].end());
    keep_newest(matches.codes);
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
