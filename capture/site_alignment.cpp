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

}  // namespace

SiteShift align(const PhotometricSignature& a, const PhotometricSignature& b) {
  constexpr int kReach = 6;  // sites
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
