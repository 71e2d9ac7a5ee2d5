#include "capture/white_level.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>

#include "capture/clip_policy.h"

namespace hdrcam {
namespace {

constexpr int kDarkestWhite = 128;    // codes of 255
constexpr double kLeastShare = 0.01;  // of the pixels, that are white
constexpr double kMostAbove = 0.1;    // of the white ones: what lies above is how compression smears them
constexpr double kMostCast = 16;      // codes of 255, between white's channels: a coloured light is not white
constexpr std::size_t kMostExposures = 9;

// Pixels by the mean code of their channels, rounded to codes of 255.
class MeanCodes {
 public:
  MeanCodes(const Image<std::uint16_t>& codes, int bits)
      : codes_(codes), scale_(255.0 / ((1 << bits) - 1) / codes.channels()) {
    for (std::size_t i = 0; i < codes.plane_size(); ++i) ++pixels_[of(i)];
  }

  std::size_t of(std::size_t pixel) const {
    std::uint32_t sum = 0;
    for (int c = 0; c < codes_.channels(); ++c) sum += codes_.plane(c)[pixel];
    return static_cast<std::size_t>(std::min(255l, std::lround(sum * scale_)));  // files may state fewer bits
  }

  std::array<double, 256> shares_below() const {
    std::array<double, 256> shares{};
    double darker = 0;
    for (std::size_t z = 0; z < shares.size(); darker += pixels_[z++])
      shares[z] = darker / static_cast<double>(codes_.plane_size());
    return shares;
  }

  // The code of white, with one of either side: many pixels have it, and hardly any is brighter.
  std::optional<std::size_t> white() const {
    const auto most = std::max_element(pixels_.begin() + kDarkestWhite, pixels_.end());
    const auto begin = most - 1, end = most + std::min<std::ptrdiff_t>(2, pixels_.end() - most);
    const double white = std::accumulate(begin, end, 0.0), above = std::accumulate(end, pixels_.end(), 0.0);
    if (white < kLeastShare * static_cast<double>(codes_.plane_size())) return std::nullopt;
    if (above > kMostAbove * white) return std::nullopt;
    return static_cast<std::size_t>(most - pixels_.begin());
  }

 private:
  const Image<std::uint16_t>& codes_;
  const double scale_;
  std::array<std::uint32_t, 256> pixels_{};
};

// The mean code of a channel where the picture is white, codes of 255.
double mean_of_white(const Image<std::uint16_t>& codes, int bits, const MeanCodes& means, std::size_t white,
                     int channel) {
  double sum = 0, pixels = 0;
  for (std::size_t i = 0; i < codes.plane_size(); ++i) {
    const std::size_t mean = means.of(i);
    if (mean + 1 < white || mean > white + 1) continue;
    sum += codes.plane(channel)[i], ++pixels;
  }
  return sum / pixels * 255 / ((1 << bits) - 1);
}

}  // namespace

double WhiteSearch::Seen::code_at(double share) const {
  return static_cast<double>(std::upper_bound(darker.begin(), darker.end(), share) - darker.begin()) - 1;
}

void WhiteSearch::observe(const RawFrame& frame) {
  if (!is_judged_ || frame.codes.empty() || !frame.facts.has_exposure()) return;
  if ((frame.facts.flags & (kFrameExposureUnproved | kFrameDamaged)) != 0) return;
  const double exposure_ev = std::log2(frame.facts.exposure());
  constexpr double kSameExposure_ev = 0.25;
  const bool is_known = std::ranges::any_of(
      seen_, [&](const Seen& seen) { return std::abs(seen.exposure_ev - exposure_ev) < kSameExposure_ev; });
  if (is_known || seen_.size() == kMostExposures) return;
  const MeanCodes means(frame.codes, bits_);
  Seen& seen = seen_.emplace_back();
  seen.exposure_ev = exposure_ev, seen.darker = means.shares_below();
  const auto white = means.white();
  if (!white) return;
  White found{static_cast<double>(*white), 1 - seen.darker[*white - 1], {}};
  for (int c = 0; c < 3; ++c)
    found.of_channel[static_cast<std::size_t>(c)] =
        mean_of_white(frame.codes, bits_, means, *white, std::min(c, frame.codes.channels() - 1));
  const auto [least, most] = std::ranges::minmax(found.of_channel);
  if (most - least <= kMostCast) seen.white = found;
}

bool WhiteSearch::is_clipped_in(const Seen& bright, const Seen& other) {
  constexpr double kApart_ev = 1, kAlike = 1.5, kMany = 16;  // codes of 255
  constexpr double kFirst = 0.1,
                   kLast = 0.9;    // of the white pixels, from the brightest: those that are compared
  constexpr double kGrown = 0.95;  // of the longer exposure's: a logo has the same share in both
  if (std::abs(other.exposure_ev - bright.exposure_ev) < kApart_ev) return false;
  const White& white = *bright.white;
  const bool is_shorter = other.exposure_ev < bright.exposure_ev;
  if (is_shorter && other.code_at(1 - kFirst * white.share) - other.code_at(1 - kLast * white.share) >= kMany)
    return true;
  if (!other.white) return false;
  const double shorter = is_shorter ? other.white->share : white.share,
               longer = is_shorter ? white.share : other.white->share;
  if (shorter > kGrown * longer) return false;
  double differ = 0;
  for (std::size_t c = 0; c < 3; ++c)
    differ = std::max(differ, std::abs(other.white->of_channel[c] - white.of_channel[c]));
  return differ <= kAlike;
}

WhiteLevel WhiteSearch::found() const {
  WhiteLevel level;
  const auto brightness = [](const Seen& seen) { return seen.white ? seen.white->mean : 0; };
  const auto bright = std::ranges::max_element(seen_, {}, brightness);
  if (bright == seen_.end() || !bright->white ||
      std::ranges::none_of(seen_, [&](const Seen& other) { return is_clipped_in(*bright, other); }))
    return level;
  for (std::size_t c = 0; c < 3; ++c)
    if (const auto code = static_cast<float>(bright->white->of_channel[c]);
        code < clip_policy::kResponseMatch.brightest)
      level.set(c, code);
  return level;
}

}  // namespace hdrcam
