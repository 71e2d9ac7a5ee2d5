#include "online/response/same_scene.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "capture/clip_policy.h"
#include "hal/core/median.h"
#include "online/response/sampled_lines.h"

namespace hdrcam {

// Medians of green over a coarse grid, -1 where they are clipped: two pictures of one scene agree in them up
// to a monotone curve, whatever lies between the exposures. Means do not: lamps and saturation move them.
SceneThumbnail thumbnail_of(const ExposedFrame& frame, int every_line) {
  constexpr int kCells = 16;
  SceneThumbnail cells;
  std::vector<float> cell;
  const auto& codes = frame.codes;
  for (int gy = 0; gy < kCells; ++gy)
    for (int gx = 0; gx < kCells; ++gx) {
      const int y0 = codes.rows() * gy / kCells, y1 = std::max(y0 + 1, codes.rows() * (gy + 1) / kCells);
      const int x0 = codes.cols() * gx / kCells, x1 = std::max(x0 + 1, codes.cols() * (gx + 1) / kCells);
      cell.clear();
      for (int y = y0; y < std::min(y1, codes.rows()); y += every_line)
        for (int x = x0; x < std::min(x1, codes.cols()); ++x) cell.push_back(codes.at(1, y, x));
      const float middle = median(cell);
      const auto [darkest, brightest] = clip_policy::kSameScene;
      cells.push_back(middle < darkest || middle > brightest ? -1 : middle);
    }
  return cells;
}

double scene_agreement(const SceneThumbnail& a, const SceneThumbnail& b, std::size_t fewest) {
  std::vector<std::size_t> both;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] >= 0 && b[i] >= 0) both.push_back(i);
  if (both.size() < fewest) return 1;
  const auto ranks = [&](const std::vector<float>& v) {
    std::vector<std::size_t> order(both.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return v[both[i]] < v[both[j]]; });
    std::vector<double> rank(both.size());
    for (std::size_t r = 0; r < order.size(); ++r) rank[order[r]] = static_cast<double>(r);
    return rank;
  };
  const auto ra = ranks(a), rb = ranks(b);
  const double n = static_cast<double>(both.size());
  double square = 0;
  for (std::size_t i = 0; i < ra.size(); ++i) square += (ra[i] - rb[i]) * (ra[i] - rb[i]);
  return 1 - 6 * square / (n * (n * n - 1));
}

bool shows_one_scene(const ExposedFrame& a, const ExposedFrame& b) {
  constexpr double kSameSceneRank = 0.35;  // a cut is near 0; a fast pan of a textured scene stays above .6
  constexpr std::size_t kFewestCells = 24;
  const int every_line = line_step(a.codes);
  return scene_agreement(thumbnail_of(a, every_line), thumbnail_of(b, every_line), kFewestCells) >=
         kSameSceneRank;
}

}  // namespace hdrcam
