#include "online/pictures/same_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "capture/clip_policy.h"
#include "hal/core/inline_list.h"
#include "hal/core/median.h"
#include "online/pictures/sparse_lines.h"

namespace hdrcam {
namespace {

constexpr std::size_t kCells = ThumbnailChannel().size();

// The places of some cells in the order of their values; equal ones share the mean of theirs.
class CellRanks {
 public:
  CellRanks(const ThumbnailChannel& values, std::span<const std::uint16_t> cells) : size_(cells.size()) {
    std::array<std::uint16_t, kCells> order{};
    for (std::size_t i = 0; i < size_; ++i) order[i] = static_cast<std::uint16_t>(i);
    const auto value = [&](std::size_t rank) { return values[cells[order[rank]]]; };
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(size_),
              [&](std::uint16_t i, std::uint16_t j) { return values[cells[i]] < values[cells[j]]; });
    for (std::size_t first = 0, end = 0; first < size_; first = end) {
      while (end < size_ && value(end) == value(first)) ++end;
      for (std::size_t r = first; r < end; ++r) ranks_[order[r]] = static_cast<double>(first + end - 1) / 2;
    }
    if (size_ > 0) spread_ = value(3 * size_ / 4) - value(size_ / 4);
  }
  float spread() const { return spread_; }  // between the quartiles of the values, in codes

  // Pearson's correlation of the ranks of the same cells; none where all of one picture are equal.
  std::optional<double> correlation(const CellRanks& other) const {
    const double mean = (static_cast<double>(size_) - 1) / 2;
    double both = 0, own = 0, others = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const double a = ranks_[i] - mean, b = other.ranks_[i] - mean;
      both += a * b, own += a * a, others += b * b;
    }
    if (own == 0 || others == 0) return std::nullopt;
    return both / std::sqrt(own * others);
  }

 private:
  std::size_t size_;
  std::array<double, kCells> ranks_{};
  float spread_ = 0;
};

using CellList = InlineList<std::uint16_t, kCells>;  // numbers of cells

CellList shown_in_both(const ThumbnailChannel& a, const ThumbnailChannel& b) {
  CellList both;
  for (std::size_t i = 0; i < kCells; ++i)
    if (a[i] >= 0 && b[i] >= 0) both.push_back(static_cast<std::uint16_t>(i));
  return both;
}

ThumbnailChannel channel_of(const Image<float>& codes, int channel, int every_line,
                            std::vector<float>& scratch) {
  const auto [darkest, brightest] = clip_policy::kSameScene;
  constexpr int kSide = kThumbnailCells;
  ThumbnailChannel cells{};
  for (int gy = 0; gy < kSide; ++gy)
    for (int gx = 0; gx < kSide; ++gx) {
      const int y0 = codes.rows() * gy / kSide, y1 = std::max(y0 + 1, codes.rows() * (gy + 1) / kSide);
      const int x0 = codes.cols() * gx / kSide, x1 = std::max(x0 + 1, codes.cols() * (gx + 1) / kSide);
      scratch.clear();
      for (int y = y0; y < std::min(y1, codes.rows()); y += every_line)
        scratch.insert(scratch.end(), codes.row(channel, y) + x0,
                       codes.row(channel, y) + std::min(x1, codes.cols()));
      const float middle = median(scratch);
      cells[static_cast<std::size_t>(gy * kSide + gx)] = middle < darkest || middle > brightest ? -1 : middle;
    }
  return cells;
}

}  // namespace

// Medians: means of one scene would not agree, lamps and saturation move them.
SceneThumbnail thumbnail_of(const ExposedFrame& frame, int every_line, std::vector<float>& scratch) {
  SceneThumbnail thumbnail;
  for (int c = 0; c < 3; ++c)
    thumbnail[static_cast<std::size_t>(c)] = channel_of(frame.codes, c, every_line, scratch);
  return thumbnail;
}

SceneThumbnail quick_thumbnail_of(const ExposedFrame& frame, std::vector<float>& scratch) {
  constexpr int kLines = 64;
  return thumbnail_of(frame, std::max(1, frame.codes.rows() / kLines), scratch);
}

double scene_agreement(const SceneThumbnail& a, const SceneThumbnail& b, std::size_t fewest_cells,
                       double presumed) {
  double sum = presumed, weights = presumed;
  for (std::size_t c = 0; c < a.size(); ++c) {
    const CellList both = shown_in_both(a[c], b[c]);
    const CellRanks of_a(a[c], both), of_b(b[c], both);
    const std::optional<double> told = both.size() < fewest_cells ? std::nullopt : of_a.correlation(of_b);
    const double weight = told ? 1 + static_cast<double>(std::min(of_a.spread(), of_b.spread())) : 1;
    sum += weight * told.value_or(1), weights += weight;
  }
  return sum / weights;
}

bool shows_scene(const SceneThumbnail& thumbnail, std::size_t fewest_cells) {
  constexpr float kLeastSpread = 2;  // codes: noise and compression alone leave one
  return std::ranges::any_of(thumbnail, [&](const ThumbnailChannel& channel) {
    const CellList shown = shown_in_both(channel, channel);
    return shown.size() >= fewest_cells && CellRanks(channel, shown).spread() >= kLeastSpread;
  });
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
