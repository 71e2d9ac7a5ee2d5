// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// A row of a patch is one vector of eight floats.
#include "online/priors/motion/flow_kernels.h"

#include "hal/core/lane_functions.h"
#include "hal/core/picture_lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

using namespace flow_constants;

typedef float Quad __attribute__((vector_size(16), aligned(4), may_alias));

inline Lanes magnitude(Lanes v) { return (Lanes)((Whole)v & 0x7fffffff); }

inline Quad fold(Lanes v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
}
// The four sums over the lanes.
inline Quad sums(Lanes a, Lanes b, Lanes c, Lanes d) {
  const Quad p = fold(a), q = fold(b), r = fold(c), s = fold(d);
  const Quad pq = __builtin_shufflevector(p, q, 0, 1, 4, 5) + __builtin_shufflevector(p, q, 2, 3, 6, 7);
  const Quad rs = __builtin_shufflevector(r, s, 0, 1, 4, 5) + __builtin_shufflevector(r, s, 2, 3, 6, 7);
  return __builtin_shufflevector(pq, rs, 0, 2, 4, 6) + __builtin_shufflevector(pq, rs, 1, 3, 5, 7);
}

constexpr float kPixels = kPatchSize * kPatchSize;

struct Vector {
  float u, v;
};

// A patch moved: the four pixels around each of its own, and how far between them.
struct Window {
  const float* at;
  float fx, fy;
};
inline Window window(const FlowPicture& to, int x, int y, Vector by) {
  const float px = clamped(static_cast<float>(x) + by.u, -kOutside,
                           static_cast<float>(to.cols - kPatchSize + kOutside - 1));
  const float py = clamped(static_cast<float>(y) + by.v, -kOutside,
                           static_cast<float>(to.rows - kPatchSize + kOutside - 1));
  // positions are positive before the cut, so that it rounds down
  const int ix = static_cast<int>(px + kOutside) - kOutside, iy = static_cast<int>(py + kOutside) - kOutside;
  return {to.gray + iy * to.pitch + ix, px - static_cast<float>(ix), py - static_cast<float>(iy)};
}

inline Lanes between(const float* p, float fx) {
  const Lanes left = load(p);
  return left + fx * (load(p + 1) - left);
}

// What a patch and its derivatives are made of, with the mean difference left out of the problem: the two
// pictures may differ by an offset.
struct Patch {
  const float *gray, *dx, *dy;
  std::ptrdiff_t pitch;
  float mean_dx, mean_dy;
  float xx, xy, yy;  // structure tensor: codes^2 per pixel^2, summed over the patch
};
inline Patch patch_at(const FlowPicture& from, int x, int y) {
  const std::ptrdiff_t offset = y * from.pitch + x;
  Patch patch{from.gray + offset, from.dx + offset, from.dy + offset, from.pitch, 0, 0, 0, 0, 0};
  Lanes sx{}, sy{}, xx{}, xy{}, yy{};
  for (int r = 0; r < kPatchSize; ++r) {
    const Lanes dx = load(patch.dx + r * from.pitch), dy = load(patch.dy + r * from.pitch);
    sx += dx, sy += dy, xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  const Quad total = sums(sx, sy, xx, yy);
  const Quad cross = sums(xy, xy, xy, xy);
  patch.mean_dx = total[0] / kPixels, patch.mean_dy = total[1] / kPixels;
  patch.xx = total[2] - total[0] * patch.mean_dx, patch.yy = total[3] - total[1] * patch.mean_dy;
  patch.xy = cross[0] - total[0] * patch.mean_dy;
  return patch;
}

// The step of Gauss and Newton, damped (Levenberg) by what the patch differs by: that much of the difference
// may be noise, and the motion is expected to be this far from where the step begins. What a texture does not
// tell against its noise stays as it is.
inline Vector step_of(const Patch& patch, float error, float bx, float by) {
  const float damping = kFlat + error / (kPixels * kExpected2);
  const float xx = patch.xx + damping, yy = patch.yy + damping, xy = patch.xy;
  const float scale = -1 / (xx * yy - xy * xy);
  return {scale * (yy * bx - xy * by), scale * (xx * by - xy * bx)};
}

// How well the patch is explained there, and the step from there.
struct Fit {
  float error;  // codes^2 over the patch
  Vector step;
};
inline Fit compare(const Patch& patch, const Window& at, std::ptrdiff_t pitch) {
  Lanes sum{}, square{}, sx{}, sy{};
  Lanes above = between(at.at, at.fx);
  for (int r = 0; r < kPatchSize; ++r) {
    const Lanes below = between(at.at + (r + 1) * pitch, at.fx);
    const Lanes d = above + at.fy * (below - above) - load(patch.gray + r * patch.pitch);
    above = below;
    sum += d, square += d * d;
    sx += d * load(patch.dx + r * patch.pitch), sy += d * load(patch.dy + r * patch.pitch);
  }
  const Quad total = sums(sum, square, sx, sy);
  const float bx = total[2] - total[0] * patch.mean_dx, by = total[3] - total[0] * patch.mean_dy;
  const float error = total[1] - total[0] * total[0] / kPixels;
  return {error, step_of(patch, error, bx, by)};
}

// One patch: the best of the guesses, then descent while it gets better. Where a patch shows nothing, in a
// black frame above all, every place looks alike, and the first guess stays.
struct Descent {
  const PatchSearch& search;
  Patch patch;
  int x, y;
  Vector best{};
  Fit fit{};

  Descent(const PatchSearch& s, int row, int col, Vector guess)
      : search(s),
        patch(),
        x(least(col * s.grid.stride, s.from.cols - kPatchSize)),
        y(least(row * s.grid.stride, s.from.rows - kPatchSize)),
        best(guess) {
    patch = patch_at(s.from, x, y);
    fit = look(guess);
  }
  Fit look(Vector at) const { return compare(patch, window(search.to, x, y, at), search.to.pitch); }
  void consider(Vector guess) {
    if (guess.u == best.u && guess.v == best.v) return;  // often: neighbours at rest, or that took this one
    const Fit other = look(guess);
    if (other.error + kLeastBetter < (1 - kBetterShare) * fit.error) best = guess, fit = other;
  }
  void descend() {
    const Vector first = best;
    for (int i = 0; i < search.steps; ++i) {
      const Vector next{best.u + fit.step.u, best.v + fit.step.v};
      if (!(fit.step.u * fit.step.u + fit.step.v * fit.step.v > kLeastStep2)) break;
      const Fit there = look(next);
      if (!(there.error < fit.error)) break;
      best = next, fit = there;
    }
    const float du = best.u - first.u, dv = best.v - first.v;
    if (!(du * du + dv * dv <= kFarthest2)) best = first;
  }
};

void search(const PatchSearch& s, int first, int last) {
  const int cols = s.grid.cols;
  const auto found = [&](int i) { return Vector{s.patches.u[i], s.patches.v[i]}; };
  const auto finish = [&](Descent& descent, int i) {
    descent.descend();
    s.patches.u[i] = descent.best.u, s.patches.v[i] = descent.best.v;
  };
  for (int row = first; row < last; ++row)
    for (int col = 0; col < cols; ++col) {
      const int i = row * cols + col;
      const bool starts = s.start_u != nullptr;
      Descent descent(s, row, col, starts ? Vector{s.start_u[i], s.start_v[i]} : found(i));
      if (starts) descent.consider(found(i));
      if (s.other_u != nullptr && s.other_u[i] != kNowhere) descent.consider({s.other_u[i], s.other_v[i]});
      if (col > 0) descent.consider(found(i - 1));
      if (row > first) descent.consider(found(i - cols));
      finish(descent, i);
    }
  for (int row = last - 1; row >= first; --row)
    for (int col = cols - 1; col >= 0; --col) {
      const int i = row * cols + col;
      Descent descent(s, row, col, found(i));
      if (col + 1 < cols) descent.consider(found(i + 1));
      if (row + 1 < last) descent.consider(found(i + cols));
      finish(descent, i);
    }
}

// What a patch's codes differ by from their mean: codes^2 over the patch.
inline float texture_of(const Patch& patch) {
  Lanes sum{}, square{};
  for (int r = 0; r < kPatchSize; ++r) {
    const Lanes codes = load(patch.gray + r * patch.pitch);
    sum += codes, square += codes * codes;
  }
  const Quad total = sums(sum, square, sum, square);
  return total[1] - total[0] * total[0] / kPixels;
}

// The place that looks most like a patch; its error as in Fit. Eight places at a time, side by side.
struct FarPlace {
  int x, y;
  float error;
};
inline FarPlace most_alike(const PatchSearch& s, const FarSearch& far, const Descent& patch) {
  const int x0 = most(0, patch.x - far.reach_x), x1 = least(s.to.cols - kPatchSize, patch.x + far.reach_x);
  const int y0 = most(0, patch.y - far.reach_y), y1 = least(s.to.rows - kPatchSize, patch.y + far.reach_y);
  Lanes best = all<Lanes>(kWorstError);
  Whole best_x{}, best_y{};
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; x += kLanes) {
      const float* to = s.to.gray + y * s.to.pitch + x;
      Lanes sum{}, square{};
      for (int r = 0; r < kPatchSize; ++r)
        for (int c = 0; c < kPatchSize; ++c) {
          const Lanes d = load(to + r * s.to.pitch + c) - patch.patch.gray[r * patch.patch.pitch + c];
          sum += d, square += d * d;
        }
      const Lanes error = square - sum * sum / kPixels;
      const Whole better = (error < best) & (x + kEachLane <= x1);
      best = better ? error : best;
      best_x = better ? x + kEachLane : best_x;
      best_y = better ? Whole{} + y : best_y;
    }
  FarPlace found{0, 0, kWorstError};
  for (int k = 0; k < kLanes; ++k)
    if (best[k] < found.error) found = {best_x[k], best_y[k], best[k]};
  return found;
}

void search_far(const PatchSearch& s, const FarSearch& far, int first, int last) {
  for (int row = first; row < last; ++row)
    for (int col = 0; col < s.grid.cols; ++col) {
      const int i = row * s.grid.cols + col;
      far.found.u[i] = far.found.v[i] = kNowhere;
      const Descent patch(s, row, col, {s.patches.u[i], s.patches.v[i]});
      const float texture = texture_of(patch.patch);
      if (!(texture >= kLeastTexture && patch.fit.error >= kExplained * texture)) continue;
      const FarPlace place = most_alike(s, far, patch);
      if (!(place.error <= least(kFound * texture, kFarBetter * patch.fit.error))) continue;
      far.found.u[i] = static_cast<float>(place.x - patch.x);
      far.found.v[i] = static_cast<float>(place.y - patch.y);
    }
}

void spread(const PatchSearch& s, int y0, int y1, FlowPlanes flow, float* weight) {
  const std::ptrdiff_t cols = s.from.cols;
  const std::ptrdiff_t begin = y0 * cols, end = y1 * cols;
  for (std::ptrdiff_t i = begin; i < end; ++i) flow.u[i] = 0, flow.v[i] = 0, weight[i] = 0;
  // the last row of patches stands off the grid, flush with the edge
  int row = most(0, (y0 - kPatchSize) / s.grid.stride);
  for (; row < s.grid.rows; ++row) {
    const int y = least(row * s.grid.stride, s.from.rows - kPatchSize);
    if (y >= y1) break;
    const int top = most(y, y0), bottom = least(y + kPatchSize, y1);
    for (int col = 0; col < s.grid.cols; ++col) {
      const int i = row * s.grid.cols + col, x = least(col * s.grid.stride, s.from.cols - kPatchSize);
      const Vector by{s.patches.u[i], s.patches.v[i]};
      const Window at = window(s.to, x, y, by);
      for (int line = top; line < bottom; ++line) {
        const float* p = at.at + (line - y) * s.to.pitch;
        const Lanes above = between(p, at.fx), below = between(p + s.to.pitch, at.fx);
        const Lanes d =
            magnitude(above + at.fy * (below - above) - load(s.from.gray + line * s.from.pitch + x));
        const Lanes w = 1 / (d > 1 ? d : Lanes{} + 1);
        const std::ptrdiff_t o = line * cols + x;
        store(flow.u + o, load(flow.u + o) + w * by.u);
        store(flow.v + o, load(flow.v + o) + w * by.v);
        store(weight + o, load(weight + o) + w);
      }
    }
  }
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const float scale = 1 / weight[i];
    flow.u[i] *= scale, flow.v[i] *= scale;
  }
}

// ---- pyramids

void halve(const float* whole, std::ptrdiff_t pitch, int rows, int cols, float* half,
           std::ptrdiff_t half_pitch) {
  for (int y = 0; y < rows; ++y) {
    const float *a = whole + 2 * y * pitch, *b = a + pitch;
    float* out = half + y * half_pitch;
    for (int x = 0; x < cols; ++x) out[x] = 0.25f * ((a[2 * x] + a[2 * x + 1]) + (b[2 * x] + b[2 * x + 1]));
  }
}

void extend(float* plane, std::ptrdiff_t pitch, int rows, int cols) {
  for (int y = 0; y < rows; ++y) {
    float* line = plane + y * pitch;
    for (int k = 1; k <= kFlowBorder; ++k) line[-k] = line[0], line[cols - 1 + k] = line[cols - 1];
  }
  for (int k = 1; k <= kFlowBorder; ++k)
    for (int x = -kFlowBorder; x < cols + kFlowBorder; ++x) {
      plane[-k * pitch + x] = plane[x];
      plane[(rows - 1 + k) * pitch + x] = plane[(rows - 1) * pitch + x];
    }
}

void derive(const float* plane, std::ptrdiff_t pitch, int rows, int cols, float* dx, float* dy) {
  for (int y = 0; y < rows; ++y) {
    const float *b = plane + y * pitch, *a = b - pitch, *c = b + pitch;
    float *gx = dx + y * pitch, *gy = dy + y * pitch;
    for (int x = 0; x < cols; ++x) {
      gx[x] = ((a[x + 1] - a[x - 1]) + 2 * (b[x + 1] - b[x - 1]) + (c[x + 1] - c[x - 1])) * 0.125f;
      gy[x] = ((c[x - 1] - a[x - 1]) + 2 * (c[x] - a[x]) + (c[x + 1] - a[x + 1])) * 0.125f;
    }
  }
}

// ---- confidence

// Whether all channels of eight pixels are clipped, bright or dark.
inline Whole clipped(const RatedBand& r, std::ptrdiff_t pixel, int count) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(r.rows) * r.cols;
  const Lanes red = load_some(r.codes + pixel, count), green = load_some(r.codes + plane + pixel, count),
              blue = load_some(r.codes + 2 * plane + pixel, count);
  return (most(most(red, green), blue) <= r.darkest) | (least(least(red, green), blue) >= r.brightest);
}

// How far eight pixels are from where they began, there and back; and whether they stay in the picture.
struct RoundTrip {
  Lanes squared;
  Whole inside;
};
inline RoundTrip round_trip(const RatedBand& r, int x, int y, std::ptrdiff_t pixel, int count) {
  constexpr float kEdge = 0.5f;  // of the outermost pixels, from their middle
  const float right = static_cast<float>(r.cols) - kEdge, bottom = static_cast<float>(r.rows) - kEdge;
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(r.rows) * r.cols;
  Lanes off[2] = {load_some(r.there + pixel, count), load_some(r.there + plane + pixel, count)};
  const Lanes to_x = lanes(x + kEachLane) + off[0], to_y = static_cast<float>(y) + off[1];
  const Nearest there = nearest(to_x, to_y, r.rows, r.cols);
  off[0] += read(r.back, there), off[1] += read(r.back + plane, there);
  return {off[0] * off[0] + off[1] * off[1],
          (to_x >= -kEdge) & (to_x <= right) & (to_y >= -kEdge) & (to_y <= bottom)};
}

void rate(const RatedBand& r) {
  constexpr int kBlock = 64;  // pixels; exponentials are a loop of their own, which then becomes vectors
  alignas(64) float confidence[kBlock];
  Whole inside[kBlock / kLanes];
  for (int y = r.y0; y < r.y1; ++y)
    for (int x0 = 0; x0 < r.cols; x0 += kBlock) {
      const int pixels = least(r.cols - x0, kBlock);
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(y) * r.cols + x0;
      for (int i = 0; i < pixels; i += kLanes) {
        const auto [squared, stays] = round_trip(r, x0 + i, y, first + i, least(pixels - i, kLanes));
        store(confidence + i, -0.5f * squared);
        inside[i / kLanes] = stays;
      }
      for (int i = 0; i < pixels; ++i) confidence[i] = exp_of(confidence[i]);
      for (int i = 0; i < pixels; i += kLanes) {
        const int count = least(pixels - i, kLanes);
        const Lanes agreed = load(confidence + i), assumed = most(all<Lanes>(r.assumed), agreed);
        const Whole blind = r.codes != nullptr ? clipped(r, first + i, count) : Whole{};
        const Lanes rated = blind ? assumed : agreed;
        store_some(r.confidence + first + i, inside[i / kLanes] ? rated : Lanes{}, count);
      }
    }
}

}  // namespace

extern const FlowKernels kFlowKernels;
const FlowKernels kFlowKernels{&halve, &extend, &derive, &search, &search_far, &spread, &rate};

}  // namespace hdrcam::HDRCAM_TARGET
