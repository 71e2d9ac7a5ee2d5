#include "online/pictures/picture_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

struct Size {
  int rows, cols;
};
constexpr std::array<Size, 5> kSizes{{{24, 40}, {17, 61}, {9, 16}, {5, 7}, {3, 12}}};  // around a vector

struct Scene {
  Size size;
  std::vector<float> pictures, flow;  // [3, rows, cols], [2, rows, cols]

  float picture(int channel, int y, int x) const {
    y = std::clamp(y, 0, size.rows - 1), x = std::clamp(x, 0, size.cols - 1);
    return pictures[static_cast<std::size_t>((channel * size.rows + y) * size.cols + x)];
  }
};

// What motion does to neighbours: they keep their distance, all but (a zoom), or not at all; some leave the
// picture, some are no number.
enum class Motion { Shift, Zoom, Chaos };

Scene scene(Size size, Motion motion) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> value(0.1f, 1), wild(-30, 30);
  const auto pixels = static_cast<std::size_t>(size.rows * size.cols);
  Scene scene{size, std::vector<float>(3 * pixels), std::vector<float>(2 * pixels)};
  for (float& v : scene.pictures) v = value(engine);
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto x = static_cast<float>(static_cast<int>(i) % size.cols),
               y = static_cast<float>(static_cast<int>(i) / size.cols);
    float &dx = scene.flow[i], &dy = scene.flow[pixels + i];
    if (motion == Motion::Shift) dx = 2.3f, dy = -1.6f;
    if (motion == Motion::Zoom) dx = 0.07f * x - 1.3f, dy = 0.9f - 0.11f * y;
    if (motion == Motion::Chaos) dx = wild(engine), dy = wild(engine);
  }
  if (motion == Motion::Chaos) scene.flow[pixels / 2] = std::numeric_limits<float>::quiet_NaN();
  return scene;
}

struct Place {
  int pixel;
  float beyond;
};
Place place(int at, float by, int size) {
  const float outside = -4, far = static_cast<float>(size + 4), to = static_cast<float>(at) + by;
  const float position = std::round(32 * (std::isnan(to) ? outside : std::clamp(to, outside, far))) / 32;
  return {static_cast<int>(std::floor(position)), position - std::floor(position)};
}

float linear_of(const Scene& s, int c, Place x, Place y) {
  const auto between = [](float a, float b, float f) { return a + f * (b - a); };
  const auto row = [&](int v) {
    return between(s.picture(c, v, x.pixel), s.picture(c, v, x.pixel + 1), x.beyond);
  };
  return between(row(y.pixel), row(y.pixel + 1), y.beyond);
}

float cubic_of(const Scene& s, int c, Place x, Place y, float limit) {
  const auto between = [](const std::array<float, 4>& p, float f) {  // Catmull and Rom
    return p[1] + 0.5f * f *
                      (p[2] - p[0] +
                       f * (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3] + f * (3 * (p[1] - p[2]) + p[3] - p[0])));
  };
  std::array<float, 4> column{};
  for (int i = 0; i < 4; ++i) {
    std::array<float, 4> row{};
    for (int k = 0; k < 4; ++k)
      row[static_cast<std::size_t>(k)] = s.picture(c, y.pixel + i - 1, x.pixel + k - 1);
    column[static_cast<std::size_t>(i)] = between(row, x.beyond);
  }
  const float cubic = between(column, y.beyond), linear = linear_of(s, c, x, y);
  return limit > 0 ? std::clamp(cubic, linear - limit, linear + limit) : cubic;
}

float largest_of(const Scene& s, int c, Place x, Place y) {
  const auto row = [&](int v) { return std::max(s.picture(c, v, x.pixel), s.picture(c, v, x.pixel + 1)); };
  return std::max(row(y.pixel), row(y.pixel + 1));
}

// Checks each sample of each scene after `warp` of it: what it writes to `out`, or to `largest`.
enum class Written { Out, Largest };
template <class Expected>
void require_warp(void (*warp)(const WarpBand&), float limit, Expected&& expected,
                  Written written = Written::Out) {
  for (const Size size : kSizes)
    for (const Motion motion : {Motion::Shift, Motion::Zoom, Motion::Chaos})
      for (const int channels : {1, 2, 3}) {
        const Scene s = scene(size, motion);
        const auto pixels = static_cast<std::size_t>(size.rows * size.cols);
        std::vector<float> out(static_cast<std::size_t>(channels) * pixels), largest(out.size());
        const float *dx = s.flow.data(), *dy = dx + pixels;
        WarpBand band{.in = s.pictures.data(),
                      .out = out.data(),
                      .dx = dx,
                      .dy = dy,
                      .channels = channels,
                      .rows = size.rows,
                      .cols = size.cols,
                      .y1 = size.rows,
                      .limit = limit};
        if (written == Written::Largest) band.largest = largest.data();
        warp(band);
        if (written == Written::Largest) out = largest;
        for (std::size_t i = 0; i < out.size(); ++i) {
          const int c = static_cast<int>(i / pixels), at = static_cast<int>(i % pixels);
          const int y = at / size.cols, x = at % size.cols;
          INFO(size.cols << " x " << size.rows << ", motion " << static_cast<int>(motion) << ", channel " << c
                         << ", pixel " << x << ", " << y);
          REQUIRE(
              out[i] ==
              Approx(expected(s, c, place(x, dx[at], size.cols), place(y, dy[at], size.rows))).epsilon(2e-5));
        }
      }
}

}  // namespace

TEST_CASE("a bilinear warp reads between four pixels, wherever neighbours go", "[isa]") {
  require_warp(picture_kernels().warp_linear, 0, linear_of);
}

TEST_CASE("a bicubic warp reads among sixteen pixels, wherever neighbours go", "[isa]") {
  for (const float limit : {0.f, 0.1f})
    require_warp(picture_kernels().warp_cubic, limit,
                 [=](const Scene& s, int c, Place x, Place y) { return cubic_of(s, c, x, y, limit); });
}

TEST_CASE("beside a bicubic warp stands the largest of the four pixels around each place", "[isa]") {
  require_warp(picture_kernels().warp_cubic, 0, largest_of, Written::Largest);
}
