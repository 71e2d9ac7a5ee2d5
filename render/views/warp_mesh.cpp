#include "render/views/warp_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdrcam {
namespace {

constexpr float kInside = -1e-4f;      // a pixel on an edge belongs to both triangles
constexpr float kTear = 1.8f;          // an edge longer than this many expected ones is torn
constexpr float kLeastArea = 1e-6f;    // of a triangle, twice, in square pixels
constexpr float kRounding_px = 1e-3f;  // of a triangle's bounds: what lies inside is found by kInside
constexpr float kFar_px = 1e6f;        // beyond any picture, and still an int

struct Corner {
  float x, y;  // in the target
  float u, v;  // in the source
  float inverse, rank, size;
};

Corner corner(const MeshVertices& vertices, int row, int col) {
  return {vertices.place.at(0, row, col),
          vertices.place.at(1, row, col),
          MeshVertices::source(col, vertices.cols()),
          MeshVertices::source(row, vertices.rows()),
          vertices.inverse.at(0, row, col),
          vertices.rank.at(0, row, col),
          vertices.size.at(0, row, col)};
}

// A band of the target's rows.
struct Band {
  int y0, y1;
  MeshAnswer* answer;
};

bool torn(const Corner& a, const Corner& b) {
  const float dx = b.x - a.x, dy = b.y - a.y, longest = kTear * 0.5f * (a.size + b.size);
  const float du = b.u - a.u, dv = b.v - a.v;  // one, half at the ring, the diagonal of both
  return dx * dx + dy * dy > longest * longest * std::max(0.25f, du * du + dv * dv);
}

void draw(const Corner& a, const Corner& b, const Corner& c, const Band& band) {
  const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  if (!(area > kLeastArea)) return;  // seen from behind: a fold where one surface slides behind another
  if (torn(a, b) || torn(b, c) || torn(c, a)) return;
  const MeshAnswer& answer = *band.answer;
  const auto first = [](float at) {
    return static_cast<int>(std::ceil(std::clamp(at, -kFar_px, kFar_px) - 0.5f - kRounding_px));
  };
  const auto last = [](float at) {
    return static_cast<int>(std::floor(std::clamp(at, -kFar_px, kFar_px) - 0.5f + kRounding_px));
  };
  const int x0 = std::max(0, first(std::min({a.x, b.x, c.x})));
  const int x1 = std::min(answer.rank.cols() - 1, last(std::max({a.x, b.x, c.x})));
  const int y0 = std::max(band.y0, first(std::min({a.y, b.y, c.y})));
  const int y1 = std::min(band.y1 - 1, last(std::max({a.y, b.y, c.y})));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
      const float wa = ((b.x - px) * (c.y - py) - (c.x - px) * (b.y - py)) / area;
      const float wb = ((c.x - px) * (a.y - py) - (a.x - px) * (c.y - py)) / area;
      const float wc = 1 - wa - wb;
      if (wa < kInside || wb < kInside || wc < kInside) continue;
      const float rank = wa * a.rank + wb * b.rank + wc * c.rank;
      float& best = band.answer->rank.at(0, y, x);
      if (rank <= best) continue;
      best = rank;
      band.answer->inverse.at(0, y, x) = wa * a.inverse + wb * b.inverse + wc * c.inverse;
      band.answer->size.at(0, y, x) = wa * a.size + wb * b.size + wc * c.size;
      band.answer->source.at(0, y, x) = wa * a.u + wb * b.u + wc * c.u;
      band.answer->source.at(1, y, x) = wa * a.v + wb * b.v + wc * c.v;
    }
}

void draw_band(const MeshVertices& vertices, const Band& band) {
  const auto above = static_cast<float>(band.y0), below = static_cast<float>(band.y1);
  const int rows = vertices.inverse.rows(), cols = vertices.inverse.cols();
  for (int row = 0; row + 1 < rows; ++row) {
    const float *y_upper = vertices.place.row(1, row), *y_lower = vertices.place.row(1, row + 1);
    const float *q_upper = vertices.inverse.row(0, row), *q_lower = vertices.inverse.row(0, row + 1);
    for (int col = 0; col + 1 < cols; ++col) {
      const float least =
          std::min(std::min(y_upper[col], y_upper[col + 1]), std::min(y_lower[col], y_lower[col + 1]));
      const float most =
          std::max(std::max(y_upper[col], y_upper[col + 1]), std::max(y_lower[col], y_lower[col + 1]));
      if (!(most >= above && least <= below)) continue;
      if (!(std::min(std::min(q_upper[col], q_upper[col + 1]), std::min(q_lower[col], q_lower[col + 1])) > 0))
        continue;
      const Corner a = corner(vertices, row, col), b = corner(vertices, row, col + 1);
      const Corner c = corner(vertices, row + 1, col), d = corner(vertices, row + 1, col + 1);
      draw(a, b, c, band);
      draw(b, d, c, band);
    }
  }
}

}  // namespace

void MeshVertices::reshape(int rows, int cols) {
  place.reshape(2, rows + 2, cols + 2);
  for (Image<float>* plane : {&inverse, &rank, &size}) plane->reshape(1, rows + 2, cols + 2);
}

float MeshVertices::source(int vertex, int size) {
  return std::clamp(static_cast<float>(vertex) - 0.5f, 0.f, static_cast<float>(size));
}

void draw_mesh(const MeshVertices& vertices, int rows, int cols, WorkerPool& pool, MeshAnswer& answer) {
  answer.source.reshape(2, rows, cols);
  for (Image<float>* plane : {&answer.inverse, &answer.rank, &answer.size}) plane->reshape(1, rows, cols);
  answer.inverse.fill(0);
  answer.rank.fill(std::numeric_limits<float>::lowest());
  constexpr int kBands = 8;  // of the target: each reads all vertices, so more would read them in vain
  pool.for_each(kBands, [&](int band) {
    draw_band(vertices, {rows * band / kBands, rows * (band + 1) / kBands, &answer});
  });
}

}  // namespace hdrcam
