// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// A row of a patch is one vector of eight floats: a register of AVX2, two of SSE or NEON.
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

typedef float Row __attribute__((vector_size(32), aligned(4), may_alias));
typedef float Quad __attribute__((vector_size(16), aligned(4), may_alias));
typedef int RowMask __attribute__((vector_size(32), aligned(4), may_alias));

inline Row load(const float* p) { return *reinterpret_cast<const Row*>(p); }
inline void store(float* p, Row v) { *reinterpret_cast<Row*>(p) = v; }
inline Row magnitude(Row v) { return (Row)((RowMask)v & 0x7fffffff); }

inline Quad fold(Row v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
}
// The four sums over the lanes.
inline Quad sums(Row a, Row b, Row c, Row d) {
  const Quad p = fold(a), q = fold(b), r = fold(c), s = fold(d);
  const Quad pq = __builtin_shufflevector(p, q, 0, 1, 4, 5) + __builtin_shufflevector(p, q, 2, 3, 6, 7);
  const Quad rs = __builtin_shufflevector(r, s, 0, 1, 4, 5) + __builtin_shufflevector(r, s, 2, 3, 6, 7);
  return __builtin_shufflevector(pq, rs, 0, 2, 4, 6) + __builtin_shufflevector(pq, rs, 1, 3, 5, 7);
}

inline int least(int a, int b) { return a < b ? a : b; }
inline int most(int a, int b) { return a > b ? a : b; }
inline float clamped(float v, float low, float high) { return v > low ? (v < high ? v : high) : low; }

constexpr float kPixels = kPatchSize * kPatchSize;
constexpr int kOutside = 16;  // pixels that a patch may leave the picture by
static_assert(kOutside + kPatchSize <= kFlowBorder);

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

inline Row between(const float* p, float fx) {
  const Row left = load(p);
  return left + fx * (load(p + 1) - left);
}

// What a patch and its derivatives are made of, with the mean difference left out of the problem: the two
// pictures may differ by an offset.
struct Patch {
  const float *gray, *dx, *dy;
  std::ptrdiff_t pitch;
  float mean_dx, mean_dy;
  float xx, xy, yy;  // inverse of the structure tensor
};
inline Patch patch_at(const FlowPicture& from, int x, int y) {
  constexpr float kLeastTexture = 1e-3f, kNoise = 4;  // codes^2: a flat patch moves by less than its noise
  const std::ptrdiff_t offset = y * from.pitch + x;
  Patch patch{from.gray + offset, from.dx + offset, from.dy + offset, from.pitch, 0, 0, 0, 0, 0};
  Row sx{}, sy{}, xx{}, xy{}, yy{};
  for (int r = 0; r < kPatchSize; ++r) {
    const Row dx = load(patch.dx + r * from.pitch), dy = load(patch.dy + r * from.pitch);
    sx += dx, sy += dy, xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  const Quad total = sums(sx, sy, xx, yy);
  const Quad cross = sums(xy, xy, xy, xy);
  patch.mean_dx = total[0] / kPixels, patch.mean_dy = total[1] / kPixels;
  const float a = total[2] - total[0] * patch.mean_dx + kNoise,
              d = total[3] - total[1] * patch.mean_dy + kNoise;
  const float b = cross[0] - total[0] * patch.mean_dy;
  float determinant = a * d - b * b;
  determinant = determinant > kLeastTexture ? determinant : kLeastTexture;
  patch.xx = d / determinant, patch.xy = -b / determinant, patch.yy = a / determinant;
  return patch;
}

// How well the patch is explained there, and the step of Gauss and Newton from there.
struct Fit {
  float error;
  Vector step;
};
inline Fit compare(const Patch& patch, const Window& at, std::ptrdiff_t pitch) {
  Row sum{}, square{}, sx{}, sy{};
  Row above = between(at.at, at.fx);
  for (int r = 0; r < kPatchSize; ++r) {
    const Row below = between(at.at + (r + 1) * pitch, at.fx);
    const Row d = above + at.fy * (below - above) - load(patch.gray + r * patch.pitch);
    above = below;
    sum += d, square += d * d;
    sx += d * load(patch.dx + r * patch.pitch), sy += d * load(patch.dy + r * patch.pitch);
  }
  const Quad total = sums(sum, square, sx, sy);
  const float bx = total[2] - total[0] * patch.mean_dx, by = total[3] - total[0] * patch.mean_dy;
  return {total[1] - total[0] * total[0] / kPixels,
          {-(patch.xx * bx + patch.xy * by), -(patch.xy * bx + patch.yy * by)}};
}

// One patch: the best of the guesses, then descent while it gets better.
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
    const Fit other = look(guess);
    if (other.error < fit.error) best = guess, fit = other;
  }
  void descend() {
    constexpr float kLeastStep2 = 1e-4f;  // pixels^2
    constexpr float kFarthest2 =
        kPatchSize * kPatchSize;  // farther off, it is another place that looks alike
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
      Descent descent(s, row, col, found(i));
      if (s.start_u != nullptr) descent.consider({s.start_u[i], s.start_v[i]});
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
        const Row above = between(p, at.fx), below = between(p + s.to.pitch, at.fx);
        const Row d =
            magnitude(above + at.fy * (below - above) - load(s.from.gray + line * s.from.pitch + x));
        const Row w = 1 / (d > 1 ? d : Row{} + 1);
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

// ---- refinement: the warped picture is linearised once; each round weighs its equations anew and sweeps

// Planes of one value per pixel. The equations of a pixel are (a11 + w) u + a12 v = c1 + sum of linked u, and
// so for v, for the whole vector (not its change); w is the sum of its links.
struct Equations {
  float *dx, *dy, *dt, *u0, *v0;
  float *a12, *c1, *c2, *link;      // link: what ties a pixel to its right and lower neighbour
  float *inverse_u, *inverse_v;     // 1 / (a11 + w), 1 / (a22 + w)
  float *none, *fresh_u, *fresh_v;  // rows: no link, and a row's new values
  Equations(float* scratch, std::ptrdiff_t plane, std::ptrdiff_t cols)
      : dx(scratch),
        dy(dx + plane),
        dt(dy + plane),
        u0(dt + plane),
        v0(u0 + plane),
        a12(v0 + plane),
        c1(a12 + plane),
        c2(c1 + plane),
        link(c2 + plane),
        inverse_u(link + plane),
        inverse_v(inverse_u + plane),
        none(inverse_v + plane),
        fresh_u(none + cols),
        fresh_v(fresh_u + cols) {}
};

void linearise(const FlowRefinement& r, const Equations& e) {
  const int rows = r.from.rows, cols = r.from.cols;
  const float right = static_cast<float>(cols) - 1.001f, bottom = static_cast<float>(rows) - 1.001f;
  const std::ptrdiff_t pitch = r.to.pitch;
  const float *gray = r.to.gray, *to_dx = r.to.dx, *to_dy = r.to.dy;
  for (int y = 0; y < rows; ++y) {
    const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * cols, own = y * r.from.pitch;
    const float* __restrict u = r.flow.u + line, * __restrict v = r.flow.v + line;
    const float *own_gray = r.from.gray + own, *own_dx = r.from.dx + own, *own_dy = r.from.dy + own;
    float* __restrict dt = e.dt + line, * __restrict dx = e.dx + line, * __restrict dy = e.dy + line;
    float* __restrict u0 = e.u0 + line, * __restrict v0 = e.v0 + line;
    for (int x = 0; x < cols; ++x) {
      const float px = clamped(static_cast<float>(x) + u[x], 0, right);
      const float py = clamped(static_cast<float>(y) + v[x], 0, bottom);
      const int ix = static_cast<int>(px), iy = static_cast<int>(py);
      const float fx = px - static_cast<float>(ix), fy = py - static_cast<float>(iy);
      const std::ptrdiff_t at = iy * pitch + ix;
      const auto read = [&](const float* plane) {
        const float *a = plane + at, *b = a + pitch;
        const float top = a[0] + fx * (a[1] - a[0]), low = b[0] + fx * (b[1] - b[0]);
        return top + fy * (low - top);
      };
      dt[x] = read(gray) - own_gray[x];
      dx[x] = 0.5f * (read(to_dx) + own_dx[x]);
      dy[x] = 0.5f * (read(to_dy) + own_dy[x]);
      u0[x] = u[x], v0[x] = v[x];
    }
  }
}

// One over the square root, in place.
void inverse_roots(float* values, int n) {
  for (int x = 0; x < n; ++x) values[x] = 1 / __builtin_sqrtf(values[x]);
}

// body(x, V{}) for all columns but `before` at the left and one at the right; V is a Row, float for what is
// over.
template <class Body>
inline void across(int before, int cols, Body&& body) {
  int x = before;
  for (; x + kPatchSize <= cols - 1; x += kPatchSize) body(x, Row{});
  for (; x < cols - 1; ++x) body(x, 0.f);
}
template <class V>
inline V get(const float* p) {
  if constexpr (sizeof(V) == sizeof(Row))
    return load(p);
  else
    return *p;
}
template <class V>
inline void put(float* p, V value) {
  if constexpr (sizeof(V) == sizeof(Row))
    store(p, value);
  else
    *p = value;
}

// What ties the pixels of row y to their right and lower neighbours: less where the flow changes.
void tie(const FlowRefinement& r, const Equations& e, int y) {
  const int rows = r.from.rows, cols = r.from.cols;
  const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * cols, next = y + 1 < rows ? cols : 0;
  const float *u = r.flow.u + line, *v = r.flow.v + line;
  float* link = e.link + line;
  const float smallest2 = r.smallest * r.smallest;
  const auto at = [&](int x, int right, auto lane) {
    using V = decltype(lane);
    const V u0 = get<V>(u + x), v0 = get<V>(v + x);
    const V ux = get<V>(u + right) - u0, uy = get<V>(u + x + next) - u0;
    const V vx = get<V>(v + right) - v0, vy = get<V>(v + x + next) - v0;
    put<V>(link + x, ux * ux + uy * uy + vx * vx + vy * vy + smallest2);
  };
  across(0, cols, [&](int x, auto lane) { at(x, x + 1, lane); });
  at(cols - 1, cols - 1, 0.f);
  inverse_roots(link, cols);
}

void weigh(const FlowRefinement& r, const Equations& e, int y) {
  constexpr float kLeastDistance2 = 1e-2f;  // pixels^2
  const int cols = r.from.cols;
  const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * cols;
  const float *u = r.flow.u + line, *v = r.flow.v + line, *u0 = e.u0 + line, *v0 = e.v0 + line;
  const float *dx = e.dx + line, *dy = e.dy + line, *dt = e.dt + line;
  const float *own = e.link + line, *above = y > 0 ? own - cols : e.none,
              *below = y + 1 < r.from.rows ? own : e.none;
  float *a12 = e.a12 + line, *c1 = e.c1 + line, *c2 = e.c2 + line;
  float *inverse_u = e.inverse_u + line, *inverse_v = e.inverse_v + line, *robust = e.fresh_u;
  const auto slope = [&](int x, auto lane) {
    using V = decltype(lane);
    const V gx = get<V>(dx + x), gy = get<V>(dy + x);
    const V rest =
        get<V>(dt + x) + gx * (get<V>(u + x) - get<V>(u0 + x)) + gy * (get<V>(v + x) - get<V>(v0 + x));
    const V size = gx * gx + gy * gy + r.slope2;
    put<V>(robust + x, size * (rest * rest + kLeastDistance2 * size));
  };
  across(0, cols, slope);
  slope(cols - 1, 0.f);
  inverse_roots(robust, cols);
  const auto at = [&](int x, auto links) {
    using V = decltype(links);
    const V gx = get<V>(dx + x), gy = get<V>(dy + x), w = r.data * get<V>(robust + x);
    const V pull = w * (gx * get<V>(u0 + x) + gy * get<V>(v0 + x) - get<V>(dt + x));
    put<V>(a12 + x, w * gx * gy);
    put<V>(c1 + x, gx * pull), put<V>(c2 + x, gy * pull);
    put<V>(inverse_u + x, 1 / (w * gx * gx + links)), put<V>(inverse_v + x, 1 / (w * gy * gy + links));
  };
  at(0, own[0] + above[0] + below[0]);
  across(1, cols, [&](int x, auto lane) {
    using V = decltype(lane);
    at(x, get<V>(own + x - 1) + get<V>(own + x) + get<V>(above + x) + get<V>(below + x));
  });
  at(cols - 1, own[cols - 2] + above[cols - 1] + below[cols - 1]);
}

// The rows of one parity: neighbours in the row as they were, those above and below as they have become.
void sweep(const FlowRefinement& r, const Equations& e, int parity) {
  constexpr float kRelaxed = 1.3f;
  const int rows = r.from.rows, cols = r.from.cols;
  for (int y = parity; y < rows; y += 2) {
    const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * cols;
    const std::ptrdiff_t up = y > 0 ? -cols : 0, down = y + 1 < rows ? cols : 0;
    float *u = r.flow.u + line, *v = r.flow.v + line;
    const float *own = e.link + line, *above = y > 0 ? own - cols : e.none,
                *below = y + 1 < rows ? own : e.none;
    const auto solve = [&](int x, int left, int right, auto to_left, auto to_right) {
      using V = decltype(to_left);
      const std::ptrdiff_t i = line + x;
      const V above_x = get<V>(above + x), below_x = get<V>(below + x), a12 = get<V>(e.a12 + i);
      const V old_u = get<V>(u + x), old_v = get<V>(v + x);
      const V su = to_left * get<V>(u + left) + to_right * get<V>(u + right) + above_x * get<V>(u + x + up) +
                   below_x * get<V>(u + x + down);
      const V sv = to_left * get<V>(v + left) + to_right * get<V>(v + right) + above_x * get<V>(v + x + up) +
                   below_x * get<V>(v + x + down);
      const V new_u = (su + get<V>(e.c1 + i) - a12 * old_v) * get<V>(e.inverse_u + i);
      const V new_v = (sv + get<V>(e.c2 + i) - a12 * new_u) * get<V>(e.inverse_v + i);
      put<V>(e.fresh_u + x, old_u + kRelaxed * (new_u - old_u));
      put<V>(e.fresh_v + x, old_v + kRelaxed * (new_v - old_v));
    };
    solve(0, 0, 1, 0.f, own[0]);
    across(1, cols, [&](int x, auto lane) {
      using V = decltype(lane);
      solve(x, x - 1, x + 1, get<V>(own + x - 1), get<V>(own + x));
    });
    solve(cols - 1, cols - 2, cols - 1, own[cols - 2], 0.f);
    __builtin_memcpy(u, e.fresh_u, sizeof(float) * static_cast<std::size_t>(cols));
    __builtin_memcpy(v, e.fresh_v, sizeof(float) * static_cast<std::size_t>(cols));
  }
}

void refine(const FlowRefinement& r) {
  const int rows = r.from.rows;
  const Equations equations(r.scratch, static_cast<std::ptrdiff_t>(rows) * r.from.cols, r.from.cols);
  for (int x = 0; x < r.from.cols; ++x) equations.none[x] = 0;
  linearise(r, equations);
  for (int round = 0; round < r.rounds; ++round) {
    for (int y = 0; y < rows; ++y) tie(r, equations, y);
    for (int y = 0; y < rows; ++y) weigh(r, equations, y);
    for (int i = 0; i < r.sweeps; ++i) sweep(r, equations, 0), sweep(r, equations, 1);
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

}  // namespace

extern const FlowKernels kFlowKernels;
const FlowKernels kFlowKernels{&halve, &extend, &derive, &search, &spread, &refine};

}  // namespace hdrcam::HDRCAM_TARGET
