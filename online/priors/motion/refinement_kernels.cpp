// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// The warped picture is linearised once; each round weighs its equations anew and sweeps over them.
#include "online/priors/motion/refinement_kernels.h"

#include "hal/core/picture_lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

using namespace flow_constants;

// What a row of pixels is solved with, one value per pixel in each line. The equations of a pixel are
// (a11 + w) u + a12 v = c1 + sum of linked u, and so for v, for the whole vector (not its change); w is the
// sum of its links. The lines of a row lie side by side, each with a margin of zeros before it and behind it,
// and above the first row and below the last there is one of zeros: what a sweep reads is near, and no pixel
// is a special case.
enum Line {
  kDx,
  kDy,
  kDt,
  kA12,
  kC1,
  kC2,
  kInverseU,  // 1 / (a11 + w)
  kInverseV,  // 1 / (a22 + w)
  kLink,      // what ties a pixel to its right and lower neighbour
  kU,
  kV,
  kLines
};
constexpr int kMargin = kLanes;

struct Layout {
  int rows_of_piece;
  std::ptrdiff_t pitch;  // floats from line to line
};
Layout layout_of(int rows, int cols) {
  return {(rows + 2 + kRefinementPieces - 1) / kRefinementPieces,
          (cols + kLanes - 1) / kLanes * kLanes + kMargin};
}
std::ptrdiff_t piece_floats(int rows, int cols) {
  const Layout layout = layout_of(rows, cols);
  return layout.rows_of_piece * kLines * layout.pitch + kMargin;
}

struct Rows {
  const FlowRefinement& r;
  Layout layout = layout_of(r.from.rows, r.from.cols);

  float* line(int y, Line which) const {  // y: -1 .. rows
    const int piece = (y + 1) / layout.rows_of_piece, row = (y + 1) % layout.rows_of_piece;
    return r.room[piece] + (row * kLines + which) * layout.pitch + kMargin;
  }
  void clear_margins() const {
    constexpr std::size_t kBytes = kMargin * sizeof(float);
    for (int y = -1; y <= r.from.rows; ++y) {
      for (int k = kDx; k < kLines; ++k) __builtin_memset(line(y, Line(k)) - kMargin, 0, kBytes);
      __builtin_memset(line(y, kV) + layout.pitch - kMargin, 0, kBytes);
    }
    clear_row(-1), clear_row(r.from.rows);
  }
  void clear_row(int y) const {
    __builtin_memset(line(y, kDx), 0, static_cast<std::size_t>(kLines * layout.pitch) * sizeof(float));
  }
};

// v up to the last of the columns that begin at x, zero beyond.
inline Lanes before_end(int cols, int x, Lanes v) { return x + kEachLane < cols ? v : Lanes{}; }

void linearise(const Rows& rows) {
  const FlowRefinement& r = rows.r;
  const int cols = r.from.cols;
  const float right = static_cast<float>(cols) - 1.001f, bottom = static_cast<float>(r.from.rows) - 1.001f;
  const int pitch = static_cast<int>(r.to.pitch);
  for (int y = 0; y < r.from.rows; ++y) {
    const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * cols, own = y * r.from.pitch;
    float *dx = rows.line(y, kDx), *dy = rows.line(y, kDy), *dt = rows.line(y, kDt);
    for (int x = 0; x < cols; x += kLanes) {
      const Lanes u = load_some(r.flow.u + line + x, cols - x), v = load_some(r.flow.v + line + x, cols - x);
      store(rows.line(y, kU) + x, u), store(rows.line(y, kV) + x, v);
      const Lanes px = clamped(lanes(x + kEachLane) + u, 0, right);
      const Lanes py = clamped(static_cast<float>(y) + v, 0, bottom);
      const Whole ix = whole(px), iy = whole(py), place = iy * pitch + ix;
      const Lanes fx = px - lanes(ix), fy = py - lanes(iy);
      const bool together = in_a_row(place);
      const auto read = [&](const float* plane) {
        return together ? between_in_a_row(plane + place[0], pitch, fx, fy)
                        : between_at(plane, pitch, place, fx, fy);
      };
      const auto keep = [&](float* to, Lanes value) { store(to + x, before_end(cols, x, value)); };
      keep(dt, read(r.to.gray) - load(r.from.gray + own + x));
      keep(dx, 0.5f * (read(r.to.dx) + load(r.from.dx + own + x)));
      keep(dy, 0.5f * (read(r.to.dy) + load(r.from.dy + own + x)));
    }
  }
}

// What ties the pixels of row y to their right and lower neighbours: less where the flow changes.
void tie(const Rows& rows, int y) {
  const int cols = rows.r.from.cols, below = y + 1 < rows.r.from.rows ? y + 1 : y;
  const float *u = rows.line(y, kU), *v = rows.line(y, kV);
  const float *u_below = rows.line(below, kU), *v_below = rows.line(below, kV);
  float* link = rows.line(y, kLink);
  const float smallest2 = rows.r.smallest * rows.r.smallest;
  for (int x = 0; x < cols; x += kLanes) {
    const Lanes u0 = load(u + x), v0 = load(v + x);
    const Lanes ux = before_end(cols - 1, x, load(u + x + 1) - u0), uy = load(u_below + x) - u0;
    const Lanes vx = before_end(cols - 1, x, load(v + x + 1) - v0), vy = load(v_below + x) - v0;
    const Lanes change2 = ux * ux + uy * uy + vx * vx + vy * vy + smallest2;
    store(link + x, before_end(cols, x, 1 / root(change2)));
  }
}

void weigh(const Rows& rows, int y) {
  const FlowRefinement& r = rows.r;
  const int cols = r.from.cols;
  const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * cols;
  const float *u = rows.line(y, kU), *v = rows.line(y, kV), *u0 = r.flow.u + line, *v0 = r.flow.v + line;
  const float *dx = rows.line(y, kDx), *dy = rows.line(y, kDy), *dt = rows.line(y, kDt);
  const float *own = rows.line(y, kLink), *above = rows.line(y - 1, kLink),
              *below = rows.line(y + 1 < r.from.rows ? y : y + 1, kLink);
  float *a12 = rows.line(y, kA12), *c1 = rows.line(y, kC1), *c2 = rows.line(y, kC2);
  float *inverse_u = rows.line(y, kInverseU), *inverse_v = rows.line(y, kInverseV);
  for (int x = 0; x < cols; x += kLanes) {
    const Lanes gx = load(dx + x), gy = load(dy + x), gt = load(dt + x);
    const Lanes at_u = load_some(u0 + x, cols - x), at_v = load_some(v0 + x, cols - x);
    const Lanes rest = gt + gx * (load(u + x) - at_u) + gy * (load(v + x) - at_v);
    const Lanes size = gx * gx + gy * gy + r.slope2;
    const Lanes w = r.data * (1 / root(size * (rest * rest + kLeastDistance2 * size)));
    const Lanes pull = w * (gx * at_u + gy * at_v - gt);
    const Lanes right = before_end(cols - 1, x, load(own + x));
    const Lanes links = load(own + x - 1) + right + load(above + x) + load(below + x);
    store(a12 + x, w * gx * gy);
    store(c1 + x, gx * pull), store(c2 + x, gy * pull);
    store(inverse_u + x, before_end(cols, x, 1 / (w * gx * gx + links)));
    store(inverse_v + x, before_end(cols, x, 1 / (w * gy * gy + links)));
  }
}

// The eight values from one before `now` on; before them stand those of `last`.
inline Lanes shifted(Lanes last, Lanes now) {
  return __builtin_shufflevector(last, now, 7, 8, 9, 10, 11, 12, 13, 14);
}

// One row: neighbours in the row as they were, those above and below as they are now.
void relax(const Rows& rows, int y) {
  const int cols = rows.r.from.cols, last = rows.r.from.rows - 1;
  float *u = rows.line(y, kU), *v = rows.line(y, kV);
  const float *u_above = rows.line(y - 1, kU), *v_above = rows.line(y - 1, kV);
  const float *u_below = rows.line(y + 1, kU), *v_below = rows.line(y + 1, kV);
  const float *own = rows.line(y, kLink), *above = rows.line(y - 1, kLink),
              *below = rows.line(y < last ? y : y + 1, kLink);
  const float *a12 = rows.line(y, kA12), *c1 = rows.line(y, kC1), *c2 = rows.line(y, kC2);
  const float *inverse_u = rows.line(y, kInverseU), *inverse_v = rows.line(y, kInverseV);
  Lanes before_u{}, before_v{};  // of the eight pixels to the left, as they were
  for (int x = 0; x < cols; x += kLanes) {
    const Lanes to_left = load(own + x - 1), to_right = load(own + x), to_above = load(above + x),
                to_below = load(below + x), a = load(a12 + x), old_u = load(u + x), old_v = load(v + x);
    const Lanes su = to_left * shifted(before_u, old_u) + to_right * load(u + x + 1) +
                     to_above * load(u_above + x) + to_below * load(u_below + x);
    const Lanes sv = to_left * shifted(before_v, old_v) + to_right * load(v + x + 1) +
                     to_above * load(v_above + x) + to_below * load(v_below + x);
    const Lanes new_u = (su + load(c1 + x) - a * old_v) * load(inverse_u + x);
    const Lanes new_v = (sv + load(c2 + x) - a * new_u) * load(inverse_v + x);
    store(u + x, old_u + kRelaxed * (new_u - old_u));
    store(v + x, old_v + kRelaxed * (new_v - old_v));
    before_u = old_u, before_v = old_v;
  }
}

// All sweeps, each over the even rows and then over the odd ones. A half sweep follows the one before it one
// row behind, so that the rows between them stay in the cache; the result is that of one after the other.
void sweep(const Rows& rows) {
  const int count = rows.r.from.rows, halves = 2 * rows.r.sweeps;
  for (int front = 0; front < count + halves; front += 2)
    for (int half = 0; half < halves && half <= front; ++half)
      if (front - half < count) relax(rows, front - half);
}

void refine(const FlowRefinement& r) {
  const Rows rows{r};
  const int count = r.from.rows;
  rows.clear_margins();
  linearise(rows);
  for (int round = 0; round < r.rounds; ++round) {
    for (int y = 0; y < count; ++y) tie(rows, y), weigh(rows, y);
    sweep(rows);
  }
  for (int y = 0; y < count; ++y) {
    const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * r.from.cols;
    const std::size_t bytes = sizeof(float) * static_cast<std::size_t>(r.from.cols);
    __builtin_memcpy(r.flow.u + line, rows.line(y, kU), bytes);
    __builtin_memcpy(r.flow.v + line, rows.line(y, kV), bytes);
  }
}

}  // namespace

extern const RefinementKernels kRefinementKernels;
const RefinementKernels kRefinementKernels{&piece_floats, &refine};

}  // namespace hdrcam::HDRCAM_TARGET
