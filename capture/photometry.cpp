#include "capture/photometry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "capture/clip_policy.h"
#include "capture/site_alignment.h"
#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Which pixels of a box are compared: the green ones of a mosaic, all of a plane.
struct Greens {
  int parity = -1;  // of x + y; -1: all
};
Greens greens(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::BayerRggb:
    case PixelLayout::BayerBggr:
      return {1};
    case PixelLayout::BayerGrbg:
    case PixelLayout::BayerGbrg:
      return {0};
    case PixelLayout::Rgb:
    case PixelLayout::Mono:
      break;
  }
  return {};
}

// Standard deviation of the scene's ln radiance.
double spread_of(const PhotometricSignature& signature) {
  constexpr double kUnknown = 2, kQuartiles = 0.7413;
  const auto sites = static_cast<std::size_t>(signature.sites);
  const double width = signature.by_rank[sites * 3 / 4] - signature.by_rank[sites / 4];
  return std::isfinite(width) ? kQuartiles * width : kUnknown;
}

}  // namespace

void Photometer::observe(const Image<std::uint16_t>& codes, PixelLayout layout, int bits,
                         PhotometricSignature& signature) const {
  constexpr int kLeastBox = 4, kMostBox = 8;  // pixels: averages noise, keeps the mosaic's phase
  signature.rows = std::min(PhotometricSignature::kSiteRows, codes.rows() / kLeastBox);
  signature.cols = std::min(PhotometricSignature::kSiteCols, codes.cols() / kLeastBox);
  const int cell =
      std::min(codes.rows() / std::max(1, signature.rows), codes.cols() / std::max(1, signature.cols));
  const int box = std::min(kMostBox, cell / 2 * 2);
  const int channel = layout == PixelLayout::Rgb ? 1 : 0;
  const int parity = greens(layout).parity;
  const float to_255 = 255.f / static_cast<float>((1 << bits) - 1);
  const auto clipped = static_cast<std::uint16_t>(clip_policy::kPhotometryClipped / to_255);

  signature.darkest_code = 255;
  std::size_t site = 0;
  int clipped_sites = 0, dark_sites = 0;
  for (int j = 0; j < signature.rows; ++j) {
    const int y0 = j * (codes.rows() - box) / std::max(1, signature.rows - 1) / 2 * 2;
    for (int i = 0; i < signature.cols; ++i, ++site) {
      const int x0 = i * (codes.cols() - box) / std::max(1, signature.cols - 1) / 2 * 2;
      int sum = 0, count = 0, cut = 0;
      for (int y = y0; y < y0 + box; ++y) {
        const std::uint16_t* row = codes.row(channel, y);
        const int step = parity < 0 ? 1 : 2;
        for (int x = x0 + (parity < 0 ? 0 : (y + parity) & 1); x < x0 + box; x += step) {
          sum += row[x], ++count;
          cut += row[x] >= clipped;
        }
      }
      const float code = static_cast<float>(sum) / static_cast<float>(count) * to_255;
      signature.darkest_code = std::min(signature.darkest_code, code);
      const float value = cut * 16 > count ? kInfinity : response_.log_exposure(code);
      signature.at_site[site] = value;
      clipped_sites += value == kInfinity, dark_sites += value == -kInfinity;
    }
  }
  signature.sites = static_cast<int>(site);
  std::copy_n(signature.at_site.begin(), site, signature.by_rank.begin());
  std::sort(signature.by_rank.begin(), signature.by_rank.begin() + static_cast<std::ptrdiff_t>(site));
  const float per_site = 1 / static_cast<float>(std::max<std::size_t>(1, site));
  signature.clipped_share = static_cast<float>(clipped_sites) * per_site;
  signature.dark_share = static_cast<float>(dark_sites) * per_site;
}

// Median of scratch_[0, count) and its standard error; `independent`: how many of the samples are.
Photometer::Centre Photometer::centre(int count, double independent) {
  const std::span samples = std::span(scratch_).first(static_cast<std::size_t>(count));
  const float middle = median(samples);
  for (float& sample : samples) sample = std::abs(sample - middle);
  const double scatter = kSigmaPerMad * median(samples);
  return {middle, scatter, scatter / std::sqrt(std::max(1.0, independent))};
}

std::optional<Photometer::Centre> Photometer::ratio_by_site(const PhotometricSignature& a,
                                                            const PhotometricSignature& b, SiteShift shift) {
  int count = 0;
  for_shared_sites(a, b, shift, [&](float x, float y) {
    const float difference = y - x;
    if (std::isfinite(difference)) scratch_[static_cast<std::size_t>(count++)] = difference;
  });
  constexpr int kLeast = 12, kSitesPerShared = 40;  // at least one site in 40 is visible in both
  if (count < kLeast || count * kSitesPerShared < a.sites) return std::nullopt;
  constexpr double kCorrelated = 25;  // neighbouring sites move together
  return centre(count, count / kCorrelated);
}

std::optional<Photometer::Centre> Photometer::ratio_by_rank(const PhotometricSignature& a,
                                                            const PhotometricSignature& b) {
  constexpr int kRanks = 120;
  int count = 0;
  for (int q = 0; q < kRanks; ++q) {
    const auto rank = static_cast<std::size_t>((2 * q + 1) * a.sites / (2 * kRanks));
    const float difference = b.by_rank[rank] - a.by_rank[rank];
    if (std::isfinite(difference)) scratch_[static_cast<std::size_t>(count++)] = difference;
  }
  if (count < 5) return std::nullopt;
  // The errors of neighbouring ranks are correlated, and content that enters the picture moves all of them,
  // so averaging helps little.
  return centre(count, 2);
}

std::optional<PhotometricRatio> Photometer::ratio(const PhotometricSignature& a,
                                                  const PhotometricSignature& b) {
  if (a.rows != b.rows || a.cols != b.cols || a.sites == 0) return std::nullopt;
  const SiteShift shift = align(a, b);
  const auto site = ratio_by_site(a, b, shift), rank = ratio_by_rank(a, b);
  if (!site || !rank) return std::nullopt;
  // Low correlation means different scenes: bright places of one are not bright in the other. A flat scene
  // cannot be tested this way.
  constexpr double kFlat = 0.15, kSameScene = 0.5;
  if (site->scatter > kFlat && correlation(a, b, shift) < kSameScene) return std::nullopt;

  constexpr double kFloor = 0.01;  // quantisation, blur and response error of a static scene
  const double site_variance = site->sigma * site->sigma + kFloor * kFloor;
  // Motion and new content in the picture shift all ranks together, so the scatter of the ranks does not show
  // them.
  constexpr double kPatches = 25;  // patches of independent content in a picture
  const double spread = spread_of(a);
  const double content =
      (site->scatter * site->scatter + 2 * spread * spread * (1 - shift.overlap)) / kPatches;
  const double rank_variance = rank->sigma * rank->sigma + content + kFloor * kFloor;
  const double variance = 1 / (1 / site_variance + 1 / rank_variance);
  const double value = variance * (site->median / site_variance + rank->median / rank_variance);
  const double disagreement = std::abs(site->median - rank->median);

  constexpr double kLamps = 0.08;  // the light itself is constant to this
  const double half_width = kLamps + 3 * std::sqrt(variance) + disagreement;
  const double stretch = response_.stretch();
  const auto outward = [&](double bound, double sign) {
    return bound * sign > 0 ? bound * stretch : bound / stretch;
  };
  return PhotometricRatio{value, outward(value - half_width, -1), outward(value + half_width, 1)};
}

}  // namespace hdrcam
