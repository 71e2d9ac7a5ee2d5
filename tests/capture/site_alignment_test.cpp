#include "capture/site_alignment.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace hdrcam {
namespace {

// Sites of a large texture, from (top, left) on, under an exposure.
PhotometricSignature part_of(const std::vector<float>& texture, int cols, int top, int left,
                             float log_exposure) {
  PhotometricSignature picture;
  picture.rows = PhotometricSignature::kSiteRows, picture.cols = PhotometricSignature::kSiteCols;
  picture.sites = PhotometricSignature::kSites;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      picture.at_site[picture.index_of(y, x)] =
          log_exposure + texture[static_cast<std::size_t>((top + y) * cols + left + x)];
  picture.by_rank = picture.at_site;
  std::sort(picture.by_rank.begin(), picture.by_rank.end());
  return picture;
}

TEST_CASE("the shift between two pictures is found whatever their exposures, up to six sites", "[capture]") {
  constexpr int kRows = 50, kCols = 60;
  std::mt19937 random(5);
  std::vector<float> texture(std::size_t{kRows} * kCols);
  for (float& value : texture) value = static_cast<float>(random() % 1000) / 500;
  const PhotometricSignature a = part_of(texture, kCols, 10, 10, 0);
  for (const int dy : {-6, -1, 0, 4}) {
    for (const int dx : {-5, 0, 2, 6}) {
      const PhotometricSignature b = part_of(texture, kCols, 10 - dy, 10 - dx, 1.4f);
      const SiteShift shift = align(a, b);
      CAPTURE(dy, dx);
      CHECK(shift.dy == dy);
      CHECK(shift.dx == dx);
      CHECK(shift.overlap == Approx((30.0 - std::abs(dy)) * (40 - std::abs(dx)) / 1200));
      CHECK(correlation(a, b, shift) == Approx(1));
    }
  }
}

TEST_CASE("pictures without a common rank are taken as not shifted", "[capture]") {
  const std::vector<float> texture(1200, -std::numeric_limits<float>::infinity());
  const PhotometricSignature dark = part_of(texture, 40, 0, 0, 0);
  const SiteShift shift = align(dark, dark);
  CHECK((shift.dy == 0 && shift.dx == 0 && shift.overlap == 1));
}

}  // namespace
}  // namespace hdrcam
