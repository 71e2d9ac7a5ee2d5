#include "online/pictures/same_scene.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "capture/clip_policy.h"
#include "hal/core/inline_list.h"
#include "hal/core/median.h"
#include "online/pictures/sparse_lines.h"

namespace hdrcam {
namespace {

constexpr std::size_t kCells = SceneThumbnail().size();
using CellList = InlineList<std::uint16_t, kCells>;  // numbers of cells

// The place of each of these cells in the order of their values; of equal ones the first comes first.
std::array<double, kCells> ranks_of(const CellList& cells, const SceneThumbnail& values) {
  std::array<std::uint16_t, kCells> order{};
  for (std::size_t i = 0; i < cells.size(); ++i) order[i] = static_cast<std::uint16_t>(i);
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(cells.size());
  std::sort(order.begin(), end, [&](std::uint16_t i, std::uint16_t j) {
    const float a = values[cells[i]], b = values[cells[j]];
    return a < b || (a == b && i < j);
  });
  std::array<double, kCells> ranks{};
  for (std::size_t r = 0; r < cells.size(); ++r) ranks[order[r]] = static_cast<double>(r);
  return ranks;
}

}  // namespace

// Medians: means of one scene would not agree, lamps and saturation move them.
SceneThumbnail thumbnail_of(const ExposedFrame& frame, int every_line, std::vector<float>& scratch) {
  const auto [darkest, brightest] = clip_policy::kSameScene;
  constexpr int kSide = kThumbnailCells;
  SceneThumbnail cells{};
  const auto& codes = frame.codes;
  for (int gy = 0; gy < kSide; ++gy)
    for (int gx = 0; gx < kSide; ++gx) {
      const int y0 = codes.rows() * gy / kSide, y1 = std::max(y0 + 1, codes.rows() * (gy + 1) / kSide);
      const int x0 = codes.cols() * gx / kSide, x1 = std::max(x0 + 1, codes.cols() * (gx + 1) / kSide);
      scratch.clear();
      for (int y = y0; y < std::min(y1, codes.rows()); y += every_line)
        for (int x = x0; x < std::min(x1, codes.cols()); ++x) scratch.push_back(codes.at(1, y, x));
      const float middle = median(scratch);
      cells[static_cast<std::size_t>(gy * kSide + gx)] = middle < darkest || middle > brightest ? -1 : middle;
    }
  return cells;
}

double scene_agreement(const SceneThumbnail& a, const SceneThumbnail& b, std::size_t fewest_cells) {
  CellList both;
  for (std::size_t i = 0; i < kCells; ++i)
    if (a[i] >= 0 && b[i] >= 0) both.push_back(static_cast<std::uint16_t>(i));
  if (both.size() < fewest_cells) return 1;
  const auto ra = ranks_of(both, a), rb = ranks_of(both, b);
  const double n = static_cast<double>(both.size());
  double square = 0;
  for (std::size_t i = 0; i < both.size(); ++i) square += (ra[i] - rb[i]) * (ra[i] - rb[i]);
  return 1 - 6 * square / (n * (n * n - 1));
}

bool shows_one_scene(const ExposedFrame& a, const ExposedFrame& b) {
  constexpr double kSameSceneRank = 0.35;  // a cut is near 0; a fast pan of a textured scene stays above .6
  constexpr std::size_t kFewestCells = 24;
  const int every_line = line_step(a.codes);
  std::vector<float> scratch;
  const SceneThumbnail of_a = thumbnail_of(a, every_line, scratch),
                       of_b = thumbnail_of(b, every_line, scratch);
  return scene_agreement(of_a, of_b, kFewestCells) >= kSameSceneRank;
}

}  // namespace hdrcam
