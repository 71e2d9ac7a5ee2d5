#include "capture/site_alignment.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace hdrcam {
namespace {

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
          std::uint64_t{signature.at_site[signature.index_of(y, x)] > threshold} << x;
  return bitmap;
}

// A rank near the middle whose sites are neither clipped nor too dark in either frame; 0: there is none.
std::size_t common_rank(const PhotometricSignature& a, const PhotometricSignature& b) {
  for (const int percent : {50, 40, 60, 30, 70, 20, 80}) {
    const auto rank = static_cast<std::size_t>(a.sites * percent / 100);
    if (std::isfinite(a.by_rank[rank]) && std::isfinite(b.by_rank[rank])) return rank;
  }
  return 0;
}

// How many of the sites that both frames see have another bit in b, whose content moved by (dy, dx).
int differing_sites(const Bitmap& a, const Bitmap& b, int dy, int dx, int rows, int cols) {
  const std::uint64_t seen = (std::uint64_t{1} << (cols - std::abs(dx))) - 1;
  const int top = std::max(0, -dy), bottom = top + rows - std::abs(dy);
  int differing = 0;
  for (int y = top; y < bottom; ++y)
    differing += std::popcount((a[static_cast<std::size_t>(y)] >> std::max(0, -dx) ^
                                b[static_cast<std::size_t>(y + dy)] >> std::max(0, dx)) &
                               seen);
  return differing;
}

}  // namespace

SiteShift align(const PhotometricSignature& a, const PhotometricSignature& b) {
  constexpr int kReach = 6;   // sites, and no more than
  constexpr int kOfSide = 5;  // a fifth of a side
  // Each site that the picture is moved by counts like this share of differing ones: flat pictures fit
  // everywhere.
  constexpr double kPerSite = 0.002;
  const std::size_t rank = common_rank(a, b);
  if (rank == 0) return {};
  const Bitmap in_a = brighter_than(a, a.by_rank[rank]), in_b = brighter_than(b, b.by_rank[rank]);
  const int reach_y = std::min(kReach, a.rows / kOfSide), reach_x = std::min(kReach, a.cols / kOfSide);
  SiteShift best;
  double least = 1;
  for (int dy = -reach_y; dy <= reach_y; ++dy) {
    for (int dx = -reach_x; dx <= reach_x; ++dx) {
      const double area = (a.cols - std::abs(dx)) * (a.rows - std::abs(dy));
      const double share = differing_sites(in_a, in_b, dy, dx, a.rows, a.cols) / area +
                           kPerSite * (std::abs(dx) + std::abs(dy));
      if (share < least) least = share, best = {dy, dx, area / a.sites};
    }
  }
  return best;
}

double correlation(const PhotometricSignature& a, const PhotometricSignature& b, SiteShift shift) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for_shared_sites(a, b, shift, [&](double x, double y) {
    if (!std::isfinite(x) || !std::isfinite(y)) return;
    n += 1, sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
  });
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  return (sab - sa * sb / n) / std::sqrt(std::max(1e-12, va * vb));
}

}  // namespace hdrcam
