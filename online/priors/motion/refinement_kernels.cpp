// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// The warped picture is linearised once; each round weighs its equations anew and sweeps
#include "online/priors/motion/refinement_kernels.h"

#include "hal/core/lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

inline float clamped(float v, float low, float high) { return v > low ? (v < high ? v : high) : low; }

// Planes of one value per pixel. The equations of a pixel are (a11 + w) u + a12 v = c1 + sum of linked u, and
// so for v, for the whole vector (not its change); w is the sum of its links.
struct Equations {
  float *dx, *dy, *dt, *u0, *v0;
  float *a12, *c1, *c2, *link;      // link: what ties a pixel to its right and lower neighbour
  float *inverse_u, *inverse_v;     // 1 / (a11 + w), 1 / (a22 + w)
  float *none, *fresh_u, *fresh_v;  // rows: no link, and a row's new values
  Equations(float* const* planes, float* lines, std::ptrdiff_t cols)
      : dx(planes[0]),
        dy(planes[1]),
        dt(planes[2]),
        u0(planes[3]),
        v0(planes[4]),
        a12(planes[5]),
        c1(planes[6]),
        c2(planes[7]),
        link(planes[8]),
        inverse_u(planes[9]),
        inverse_v(planes[10]),
        none(lines),
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

// body(x, V{}) for all columns but `before` at the left and one at the right; V is a Lanes, float for what is
// over.
template <class Body>
inline void across(int before, int cols, Body&& body) {
  int x = before;
  for (; x + kLanes <= cols - 1; x += kLanes) body(x, Lanes{});
  for (; x < cols - 1; ++x) body(x, 0.f);
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

// One row: neighbours in the row as they were, those above and below as they are now.
void relax(const FlowRefinement& r, const Equations& e, int y) {
  constexpr float kRelaxed = 1.3f;
  const int rows = r.from.rows, cols = r.from.cols;
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

// All sweeps, each over the even rows and then over the odd ones. A half sweep follows the one before it one
// row behind, so that the rows between them stay in the cache; the result is that of one after the other.
void sweep(const FlowRefinement& r, const Equations& e) {
  const int rows = r.from.rows, halves = 2 * r.sweeps;
  for (int front = 0; front < rows + halves; front += 2)
    for (int half = 0; half < halves && half <= front; ++half)
      if (front - half < rows) relax(r, e, front - half);
}

void refine(const FlowRefinement& r) {
  const int rows = r.from.rows;
  const Equations equations(r.planes, r.lines, r.from.cols);
  for (int x = 0; x < r.from.cols; ++x) equations.none[x] = 0;
  linearise(r, equations);
  for (int round = 0; round < r.rounds; ++round) {
    for (int y = 0; y < rows; ++y) tie(r, equations, y), weigh(r, equations, y);
    sweep(r, equations);
  }
}

}  // namespace

extern const RefinementKernels kRefinementKernels;
const RefinementKernels kRefinementKernels{&refine};

}  // namespace hdrcam::HDRCAM_TARGET
