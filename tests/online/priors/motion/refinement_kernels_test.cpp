#include "online/priors/motion/refinement_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "hal/core/image.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// A texture moved by `shift` pixels, with its derivatives, and a border as the search wants it.
struct Picture {
  Image<float> planes;
  FlowPicture view{};

  Picture(int rows, int cols, float shift) : planes(3, rows + 2 * kFlowBorder, cols + 2 * kFlowBorder) {
    for (int y = 0; y < planes.rows(); ++y)
      for (int x = 0; x < planes.cols(); ++x) {
        const float u = 0.4f * (static_cast<float>(x) + shift), v = 0.3f * static_cast<float>(y);
        planes.at(0, y, x) = 120 + 50 * std::sin(u) * std::cos(v);
        planes.at(1, y, x) = 50 * 0.4f * std::cos(u) * std::cos(v);
        planes.at(2, y, x) = -50 * 0.3f * std::sin(u) * std::sin(v);
      }
    const auto origin = [&](int c) { return planes.row(c, kFlowBorder) + kFlowBorder; };
    view = {origin(0), origin(1), origin(2), planes.cols(), rows, cols};
  }
};

// The same equations, a pixel at a time, without rows that share memory or margins.
class Twin {
 public:
  Twin(const FlowRefinement& refinement, Image<float>& flow)
      : r(refinement), rows(r.from.rows), cols(r.from.cols), flow_(flow), start_(flow.clone()) {}

  void refine() {
    for (int round = 0; round < r.rounds; ++round) {
      weigh();
      for (int half = 0; half < 2 * r.sweeps; ++half) {
        const Image<float> before = flow_.clone();
        for (int y = half % 2; y < rows; y += 2)
          for (int x = 0; x < cols; ++x) relax(before, y, x);
      }
    }
  }

 private:
  float read(const float* plane, int y, int x) const {
    const float px =
        std::clamp(static_cast<float>(x) + start_.at(0, y, x), 0.f, static_cast<float>(cols) - 1.001f);
    const float py =
        std::clamp(static_cast<float>(y) + start_.at(1, y, x), 0.f, static_cast<float>(rows) - 1.001f);
    const int ix = static_cast<int>(px), iy = static_cast<int>(py);
    const float fx = px - static_cast<float>(ix), fy = py - static_cast<float>(iy);
    const float *a = plane + iy * r.to.pitch + ix, *b = a + r.to.pitch;
    return (1 - fy) * ((1 - fx) * a[0] + fx * a[1]) + fy * ((1 - fx) * b[0] + fx * b[1]);
  }
  void weigh() {
    links_.assign(static_cast<std::size_t>(rows * cols), 0);
    equations_.resize(links_.size());
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        float change2 = r.smallest * r.smallest;
        for (int c = 0; c < 2; ++c) {
          const float own = flow_.at(c, y, x);
          change2 += std::pow(flow_.at(c, y, std::min(x + 1, cols - 1)) - own, 2.f);
          change2 += std::pow(flow_.at(c, std::min(y + 1, rows - 1), x) - own, 2.f);
        }
        links_[index(y, x)] = 1 / std::sqrt(change2);
      }
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        const std::ptrdiff_t at = y * r.from.pitch + x;
        const float gx = 0.5f * (read(r.to.dx, y, x) + r.from.dx[at]);
        const float gy = 0.5f * (read(r.to.dy, y, x) + r.from.dy[at]);
        const float gt = read(r.to.gray, y, x) - r.from.gray[at];
        const float u0 = start_.at(0, y, x), v0 = start_.at(1, y, x);
        const float rest = gt + gx * (flow_.at(0, y, x) - u0) + gy * (flow_.at(1, y, x) - v0);
        const float size = gx * gx + gy * gy + r.slope2;
        const float w = r.data / std::sqrt(size * (rest * rest + 0.01f * size));
        const float pull = w * (gx * u0 + gy * v0 - gt);
        equations_[index(y, x)] = {w * gx * gx, w * gx * gy, w * gy * gy, gx * pull, gy * pull};
      }
  }
  void relax(const Image<float>& before, int y, int x) {
    struct Neighbour {
      int y, x;
      float link;
    };
    const std::array<Neighbour, 4> around{{{y, x - 1, x > 0 ? links_[index(y, x - 1)] : 0},
                                           {y, x + 1, x + 1 < cols ? links_[index(y, x)] : 0},
                                           {y - 1, x, y > 0 ? links_[index(y - 1, x)] : 0},
                                           {y + 1, x, y + 1 < rows ? links_[index(y, x)] : 0}}};
    float w = 0, su = 0, sv = 0;
    for (const auto& [ny, nx, link] : around) {
      if (link == 0) continue;
      w += link, su += link * before.at(0, ny, nx), sv += link * before.at(1, ny, nx);
    }
    const auto& [a11, a12, a22, c1, c2] = equations_[index(y, x)];
    const float u = before.at(0, y, x), v = before.at(1, y, x);
    const float new_u = (su + c1 - a12 * v) / (a11 + w), new_v = (sv + c2 - a12 * new_u) / (a22 + w);
    flow_.at(0, y, x) = u + 1.3f * (new_u - u), flow_.at(1, y, x) = v + 1.3f * (new_v - v);
  }
  std::size_t index(int y, int x) const { return static_cast<std::size_t>(y * cols + x); }

  const FlowRefinement& r;
  const int rows, cols;
  Image<float>& flow_;
  const Image<float> start_;
  std::vector<float> links_;
  std::vector<std::array<float, 5>> equations_;
};

}  // namespace

TEST_CASE("a flow is refined as its equations say, whatever the width of the picture", "[isa]") {
  for (const auto& [rows, cols] : {std::pair{16, 16}, {17, 23}, {24, 40}, {33, 61}}) {
    const Picture from(rows, cols, 0), to(rows, cols, 1.4f);
    Image<float> flow(2, rows, cols);
    for (int y = 0; y < rows; ++y)  // rough, and at the edges out of the picture
      for (int x = 0; x < cols; ++x) {
        flow.at(0, y, x) = -1.4f + 0.8f * std::sin(static_cast<float>(7 * x + 3 * y));
        flow.at(1, y, x) = 0.6f * std::cos(static_cast<float>(5 * x - 2 * y));
      }
    Image<float> expected = flow.clone();
    const auto piece = static_cast<int>(refinement_kernels().piece_floats(rows, cols));
    Image<float> room(kRefinementPieces, 1, piece);
    room.fill(1e6f);  // what others left there
    FlowRefinement refinement{from.view, to.view, {flow.plane(0), flow.plane(1)}, {}, 0.5f, 10, 0.1f, 2, 3};
    for (int i = 0; i < kRefinementPieces; ++i) refinement.room[i] = room.plane(i);
    Twin(refinement, expected).refine();
    refinement_kernels().refine(refinement);
    for (int c = 0; c < 2; ++c)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x) {
          INFO(cols << " x " << rows << ", component " << c << ", pixel " << x << ", " << y);
          REQUIRE(flow.at(c, y, x) == Approx(expected.at(c, y, x)).margin(2e-3));
        }
  }
}
