#include "capture/photometry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "capture/clip_policy.h"
#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr std::size_t kGreen = 1;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// ln relative exposure of the mean of 201 real responses, at these codes of 255. Made with the DoRF database
// (Grossberg & Nayar, CVPR 2003): each curve inverted, logarithms averaged.
struct Knot {
  float code, log_exposure;
};
constexpr Knot kMeanCamera[] = {
    {1, -6.627f},   {2, -6.002f},   {4, -5.367f},   {6, -4.989f},   {8, -4.714f},   {12, -4.306f},
    {16, -4.011f},  {24, -3.579f},  {32, -3.262f},  {48, -2.799f},  {64, -2.448f},  {80, -2.156f},
    {96, -1.907f},  {112, -1.686f}, {128, -1.486f}, {144, -1.3f},   {160, -1.125f}, {176, -0.954f},
    {192, -0.784f}, {208, -0.614f}, {224, -0.438f}, {240, -0.245f}, {250, -0.1f},   {255, 0.f}};

float mean_camera(float code) {
  const Knot* above = std::upper_bound(std::begin(kMeanCamera) + 1, std::end(kMeanCamera) - 1, code,
                                       [](float c, const Knot& knot) { return c < knot.code; });
  const Knot* below = above - 1;
  const float t = (code - below->code) / (above->code - below->code);
  return below->log_exposure + t * (above->log_exposure - below->log_exposure);
}

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

std::size_t index_of(const PhotometricSignature& signature, int y, int x) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(signature.cols) + static_cast<std::size_t>(x);
}

// Calls body(value in a, value in b) for the sites that the two frames share.
template <class Body>
void for_shared_sites(const PhotometricSignature& a, const PhotometricSignature& b, SiteShift shift,
                      Body&& body) {
  const int y1 = std::min(a.rows, a.rows - shift.dy), x1 = std::min(a.cols, a.cols - shift.dx);
  for (int y = std::max(0, -shift.dy); y < y1; ++y)
    for (int x = std::max(0, -shift.dx); x < x1; ++x)
      body(a.at_site[index_of(a, y, x)], b.at_site[index_of(a, y + shift.dy, x + shift.dx)]);
}

// Marks the sites that are brighter than the site of a given rank; they are the same for every exposure
// (Ward, "Fast, robust image registration for compositing high dynamic range photographs from hand-held
// exposures", 2003). One word per row.
using Bitmap = std::array<std::uint64_t, PhotometricSignature::kSiteRows>;
static_assert(PhotometricSignature::kSiteCols <= 64);

Bitmap brighter_than(const PhotometricSignature& signature, float threshold) {
  Bitmap bitmap{};
  for (int y = 0; y < signature.rows; ++y)
    for (int x = 0; x < signature.cols; ++x)
      bitmap[static_cast<std::size_t>(y)] |=
          std::uint64_t{signature.at_site[index_of(signature, y, x)] > threshold} << x;
  return bitmap;
}

// The shift under which the two bitmaps differ least, within a sixth of the picture; zero where the frames
// have no common rank.
SiteShift align(const PhotometricSignature& a, const PhotometricSignature& b) {
  constexpr int kReach = 6;
  std::size_t rank = 0;
  for (const int percent : {50, 40, 60, 30, 70, 20, 80}) {
    rank = static_cast<std::size_t>(a.sites * percent / 100);
    if (std::isfinite(a.by_rank[rank]) && std::isfinite(b.by_rank[rank])) break;
    rank = 0;
  }
  if (rank == 0) return {};
  const Bitmap in_a = brighter_than(a, a.by_rank[rank]), in_b = brighter_than(b, b.by_rank[rank]);

  SiteShift best;
  double least = 1;
  for (int dy = -std::min(kReach, a.rows / 5); dy <= std::min(kReach, a.rows / 5); ++dy) {
    for (int dx = -std::min(kReach, a.cols / 5); dx <= std::min(kReach, a.cols / 5); ++dx) {
      const int width = a.cols - std::abs(dx), height = a.rows - std::abs(dy);
      const std::uint64_t seen = (std::uint64_t{1} << width) - 1;
      int differing = 0;
      for (int y = std::max(0, -dy); y < std::max(0, -dy) + height; ++y) {
        const int y_in_b = y + dy;
        differing += std::popcount((in_a[static_cast<std::size_t>(y)] >> std::max(0, -dx) ^
                                    in_b[static_cast<std::size_t>(y_in_b)] >> std::max(0, dx)) &
                                   seen);
      }
      const double area = width * height;
      // A small preference for no motion, since flat pictures fit everywhere.
      const double share = differing / area + 0.002 * (std::abs(dx) + std::abs(dy));
      if (share < least) least = share, best = {dy, dx, area / a.sites};
    }
  }
  return best;
}

// Pearson's correlation of the sites that both frames see.
double correlation(const PhotometricSignature& a, const PhotometricSignature& b, SiteShift shift) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for_shared_sites(a, b, shift, [&](double x, double y) {
    if (!std::isfinite(x) || !std::isfinite(y)) return;
    n += 1, sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
  });
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  return (sab - sa * sb / n) / std::sqrt(std::max(1e-12, va * vb));
}

// Standard deviation of the scene's ln radiance.
double spread_of(const PhotometricSignature& signature) {
  constexpr double kUnknown = 2, kQuartiles = 0.7413;
  const auto sites = static_cast<std::size_t>(signature.sites);
  const double width = signature.by_rank[sites * 3 / 4] - signature.by_rank[sites / 4];
  return std::isfinite(width) ? kQuartiles * width : kUnknown;
}

}  // namespace

PhotometricResponse PhotometricResponse::unknown() {
  PhotometricResponse response(24, 2.8);
  for (std::size_t z = 0; z < 256; ++z) response.log_[z] = mean_camera(static_cast<float>(z));
  return response;
}

PhotometricResponse PhotometricResponse::linear(const BlackLevel& black_level) {
  const float black = black_level[kGreen];
  PhotometricResponse response(black + 6, 1.03);
  response.linear_ = true;
  response.black_ = black;
  return response;
}

// Black is assumed in the middle of its range. At the darkest code that is used it may be wrong by a quarter
// of the light, which moves the logarithm of a ratio of two by less than `stretch`.
PhotometricResponse PhotometricResponse::linear_unknown_black(float most) {
  PhotometricResponse response(2 * most + 4, 1.05 + 0.75 * static_cast<double>(most / kMostBlack));
  response.linear_ = true;
  response.black_ = most / 2;
  return response;
}

PhotometricResponse PhotometricResponse::known(const Curve& inverse, const BlackLevel& black_level) {
  const float black = black_level[kGreen];
  PhotometricResponse response(black + 8, 1.1);
  for (std::size_t z = 0; z < 256; ++z) {
    const float code = std::max(0.f, (static_cast<float>(z) - black) * 255 / (255 - black));
    const auto below = std::min<std::size_t>(254, static_cast<std::size_t>(code));
    const float t = code - static_cast<float>(below);
    response.log_[z] = std::log(std::max(1e-6f, inverse[below] + t * (inverse[below + 1] - inverse[below])));
  }
  return response;
}

float PhotometricResponse::log_exposure(float code) const {
  if (code < darkest_) return -kInfinity;
  if (code >= clip_policy::kPhotometryClipped) return kInfinity;
  if (linear_) return std::log(code - black_);
  const auto below = static_cast<std::size_t>(code);
  return log_[below] + (code - static_cast<float>(below)) * (log_[below + 1] - log_[below]);
}

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
  constexpr int kLeastShare = 40;  // 1/40 of the sites
  if (count < 12 || count * kLeastShare < a.sites) return std::nullopt;
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
