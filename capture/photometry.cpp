#include "capture/photometry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "capture/site_alignment.h"
#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Which pixels of a box are measured: the green ones of a mosaic, all of a plane.
struct Greens {
  int channel = 0;
  int step = 1;    // from one to the next in a row
  int parity = 0;  // of x + y of the first, where they are every second one
};
Greens greens(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::BayerRggb:
    case PixelLayout::BayerBggr:
      return {0, 2, 1};
    case PixelLayout::BayerGrbg:
    case PixelLayout::BayerGbrg:
      return {0, 2, 0};
    case PixelLayout::Rgb:
      return {.channel = 1};
    case PixelLayout::Mono:
      break;
  }
  return {};
}

struct Box {
  int y = 0, x = 0, side = 0;
};
struct BoxCodes {
  int sum = 0, count = 0, clipped = 0;

  float mean() const { return static_cast<float>(sum) / static_cast<float>(count); }
  // One pixel in sixteen, and the mean is no measure of the light.
  bool is_clipped() const { return clipped * 16 > count; }
};
BoxCodes codes_in(const Image<std::uint16_t>& codes, const Greens& green, const Box& box,
                  std::uint16_t clipped) {
  BoxCodes found;
  for (int y = box.y; y < box.y + box.side; ++y) {
    const std::uint16_t* row = codes.row(green.channel, y);
    const int first = green.step == 1 ? 0 : (y + green.parity) & 1;
    for (int x = box.x + first; x < box.x + box.side; x += green.step) {
      found.sum += row[x], ++found.count;
      found.clipped += row[x] >= clipped;
    }
  }
  return found;
}

// Of the i-th of `count` boxes that are spread over `extent` pixels: even, which keeps the mosaic's phase.
int box_begin(int i, int count, int extent, int box) {
  return i * (extent - box) / std::max(1, count - 1) / 2 * 2;
}

// Standard deviation of the scene's ln radiance.
double spread_of(const PhotometricSignature& signature) {
  constexpr double kUnknown = 2, kQuartiles = 0.7413;  // of normal values over the width of their quartiles
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
  const Greens green = greens(layout);
  const float to_255 = 255.f / static_cast<float>((1 << bits) - 1);
  const auto clipped = static_cast<std::uint16_t>(response_.clipped_from() / to_255);

  signature.darkest_code = 255;
  std::size_t site = 0;
  int clipped_sites = 0, dark_sites = 0;
  for (int j = 0; j < signature.rows; ++j) {
    const int y0 = box_begin(j, signature.rows, codes.rows(), box);
    for (int i = 0; i < signature.cols; ++i, ++site) {
      const int x0 = box_begin(i, signature.cols, codes.cols(), box);
      const BoxCodes found = codes_in(codes, green, {y0, x0, box}, clipped);
      const float code = found.mean() * to_255;
      signature.darkest_code = std::min(signature.darkest_code, code);
      const float value = found.is_clipped() ? kInfinity : response_.log_exposure(code);
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
  constexpr int kLeast = 5;
  if (count < kLeast) return std::nullopt;
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
