#include "render/black_channels.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "render/channel_rows.h"

namespace hdrcam {
namespace {

using Colour = std::array<float, 3>;

constexpr float kSure = 0.02f, kUnsure = 0.3f;  // variance of ln radiance: at most, and from which on

// Of the pixels that are sure of all channels: what each has of their mean. None where there are few.
std::optional<Colour> usual_colour(const BlackChannels& black, const RadianceEstimate& seen) {
  constexpr int kStride = 6, kEnough = 20;  // pixels
  Colour sum{};
  int count = 0;
  for (int y = kStride / 2; y < seen.radiance.rows(); y += kStride) {
    const auto radiance = rows_of(seen.radiance, y), variance = rows_of(seen.variance, y);
    for (int x = kStride / 2; x < seen.radiance.cols(); x += kStride) {
      Colour r;
      bool sure = true;
      for (std::size_t c = 0; c < 3; ++c) {
        r[c] = radiance[c][x] + black.offset;
        sure = sure && variance[c][x] < kSure * r[c] * r[c];
      }
      if (!sure) continue;
      const float mean = (r[0] + r[1] + r[2]) / 3;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += r[c] / mean;
      ++count;
    }
  }
  if (count < kEnough) return std::nullopt;
  for (float& s : sum) s /= static_cast<float>(count);
  return sum;
}

// The level that the other channels tell of a pixel: the mean of those that are sure, else the least that any
// of them can be; each over its share of the usual colour.
float level_of(const Colour& r, const Colour& variance, const Colour& usual, float unseen_from) {
  float sum = 0, least = std::numeric_limits<float>::max();
  int count = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (variance[c] >= unseen_from) continue;
    const float level = r[c] / usual[c];
    least = std::min(least, level);
    if (variance[c] <= kUnsure * r[c] * r[c]) sum += level, ++count;
  }
  return count > 0 ? sum / static_cast<float>(count) : least;
}

}  // namespace

void colour_black_channels(const BlackChannels& black, const RadianceEstimate& seen, Image<float>& coloured,
                           WorkerPool& pool) {
  const std::optional<Colour> found = usual_colour(black, seen);
  const int rows = seen.radiance.rows(), cols = seen.radiance.cols();
  coloured.reshape_like(seen.radiance);
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const auto radiance = rows_of(seen.radiance, y), variances = rows_of(seen.variance, y);
      const auto out = rows_of(coloured, y);
      for (std::size_t c = 0; c < 3; ++c) std::copy_n(radiance[c], cols, out[c]);
      if (!found) continue;
      const Colour& usual = *found;
      for (int x = 0; x < cols; ++x) {
        if (radiance[0][x] > black.darkest[0] && radiance[1][x] > black.darkest[1] &&
            radiance[2][x] > black.darkest[2])
          continue;
        Colour r, variance;
        for (std::size_t c = 0; c < 3; ++c)
          r[c] = radiance[c][x] + black.offset, variance[c] = variances[c][x];
        const float level = level_of(r, variance, usual, black.unseen_from);
        for (std::size_t c = 0; c < 3; ++c) {
          if (radiance[c][x] > black.darkest[c] || variance[c] >= black.unseen_from) continue;
          const float spread = variance[c] / (r[c] * r[c]), likely = usual[c] * level;
          if (spread < kUnsure || likely >= r[c]) continue;
          const float share = spread / (spread + 1);  // colours vary by about a factor of e
          out[c][x] = std::max(0.f, r[c] + share * (likely - r[c]) - black.offset);
        }
      }
    }
  });
}

}  // namespace hdrcam
