#include "render/shrinkage.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr float kOffset = 1e-3f;

// A ramp with texture, [3, rows, cols], and the noise of a known relative deviation on it.
struct Noisy {
  Image<float> clean, radiance, variance;
  Noisy(int rows, int cols, float deviation, unsigned seed = 1)
      : clean(3, rows, cols), radiance(3, rows, cols), variance(3, rows, cols) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x) {
          const float value = std::exp(0.05f * static_cast<float>(x) - 0.03f * static_cast<float>(y)) *
                              (1 + 0.3f * std::sin(0.4f * static_cast<float>(x + y + 3 * c)));
          clean.at(c, y, x) = value;
          radiance.at(c, y, x) = std::max(0.f, value * (1 + deviation * normal(random)));
          variance.at(c, y, x) = deviation * deviation * value * value;
        }
  }
};

double relative_error(const Image<float>& a, const Image<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double ratio = (a.samples()[i] + kOffset) / (b.samples()[i] + kOffset);
    sum += std::log(ratio) * std::log(ratio);
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// The same filter as its header describes it, in double precision and without a thought for time.
Image<float> plainly(const Image<float>& radiance, const Image<float>& variance,
                     const ShrinkageThresholds& thresholds, const ShrinkageGrid& grid) {
  constexpr double kT[3][3] = {
      {0.57735, 0.57735, 0.57735}, {-0.70711, 0, 0.70711}, {0.40825, -0.81650, 0.40825}};
  const int rows = radiance.rows(), cols = radiance.cols();
  double dct[8][8];
  for (int k = 0; k < 8; ++k)
    for (int n = 0; n < 8; ++n)
      dct[k][n] =
          (k > 0 ? std::sqrt(0.25) : std::sqrt(0.125)) * std::cos(std::numbers::pi * (2 * n + 1) * k / 16);
  const auto at = [&](int y, int x) { return static_cast<std::size_t>(y * cols + x); };
  std::array<std::vector<double>, 3> o, noise, sum, weight;
  for (std::size_t c = 0; c < 3; ++c)
    for (auto* plane : {&o[c], &noise[c], &sum[c], &weight[c]}) plane->assign(radiance.plane_size(), 0);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) {
          const double a = std::max(0.f, radiance.at(k, y, x)) + kOffset, t = kT[c][k];
          o[c][at(y, x)] += t * std::log(a);
          noise[c][at(y, x)] += t * t * std::min(0.25, variance.at(k, y, x) / (a * a));
        }
  const auto starts = [](int size, int first, int step) {
    std::vector<int> places;
    for (int p = first; p + 8 <= size; p += step) places.push_back(p);
    if (places.empty() || places.back() != size - 8) places.push_back(size - 8);
    return places;
  };
  for (std::size_t c = 0; c < 3; ++c)
    for (int line = 0; const int y0 : starts(rows, 0, grid.line_step))
      for (const int x0 : starts(cols, y0 < rows - 8 ? line++ % 2 * grid.shift : 0, 4)) {
        double s[8][8] = {}, back[8][8] = {}, s2 = 0, energy = 1;
        for (int y = 0; y < 8; ++y)
          for (int x = 0; x < 8; ++x) s2 += noise[c][at(y0 + y, x0 + x)] / 64;
        for (int i = 0; i < 8; ++i)
          for (int j = 0; j < 8; ++j)
            for (int y = 0; y < 8; ++y)
              for (int x = 0; x < 8; ++x) s[i][j] += dct[i][y] * dct[j][x] * o[c][at(y0 + y, x0 + x)];
        for (int i = 0; i < 8; ++i)
          for (int j = 0; j < 8; ++j) {
            if (i + j == 0) continue;
            const double threshold = (c == 0 ? 1 : thresholds.chroma) * thresholds.least *
                                     (1 + static_cast<double>(thresholds.rise) * i / 7) *
                                     (1 + static_cast<double>(thresholds.rise) * j / 7);
            const double gain =
                std::max(0., (s[i][j] * s[i][j] - threshold * s2) / (s[i][j] * s[i][j] + 1e-12));
            s[i][j] *= gain, energy += gain * gain;
          }
        for (int y = 0; y < 8; ++y)
          for (int x = 0; x < 8; ++x)
            for (int i = 0; i < 8; ++i)
              for (int j = 0; j < 8; ++j) back[y][x] += dct[i][y] * dct[j][x] * s[i][j];
        const double w = 1 / (energy * (s2 + 1e-6));
        for (int y = 0; y < 8; ++y)
          for (int x = 0; x < 8; ++x)
            sum[c][at(y0 + y, x0 + x)] += w * back[y][x], weight[c][at(y0 + y, x0 + x)] += w;
      }
  Image<float> out(3, rows, cols);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x)
      for (int k = 0; k < 3; ++k) {
        double value = 0;
        for (std::size_t c = 0; c < 3; ++c) value += kT[c][k] * sum[c][at(y, x)] / weight[c][at(y, x)];
        out.at(k, y, x) = static_cast<float>(std::max(0., std::exp(value) - kOffset));
      }
  return out;
}

}  // namespace

TEST_CASE("shrinkage does what its header says, for sizes that are no multiple of its tiles", "[isa]") {
  const auto [rows, cols] = GENERATE(table<int, int>({{8, 8}, {9, 9}, {24, 40}, {29, 35}, {27, 38}}));
  const NoiseOrigin origin = GENERATE(NoiseOrigin::Sensor, NoiseOrigin::Unknown);
  const ShrinkageEffort effort = GENERATE(ShrinkageEffort::On, ShrinkageEffort::Dense);
  const Noisy picture(rows, cols, 0.1f);
  const Image<float> expected =
      plainly(picture.radiance, picture.variance, thresholds_of(origin), grid_of(effort));
  Image<float> found = picture.radiance.clone();
  WorkerPool pool(2);
  Shrinkage(pool).apply(found, picture.variance, {kOffset, origin, effort});
  CAPTURE(rows, cols, origin, effort);
  CHECK(relative_error(found, expected) < 2e-5);
}

TEST_CASE("shrinkage takes noise away and leaves alone what is sure", "[isa]") {
  WorkerPool pool(1);
  Shrinkage shrinkage(pool);
  Noisy noisy(48, 64, 0.1f);
  Image<float> found = noisy.radiance.clone();
  const NoiseOrigin origin = GENERATE(NoiseOrigin::Sensor, NoiseOrigin::Unknown);
  shrinkage.apply(found, noisy.variance, {kOffset, origin});
  CHECK(relative_error(found, noisy.clean) < 0.7 * relative_error(noisy.radiance, noisy.clean));

  found.copy_from(noisy.radiance);
  noisy.variance.fill(0);
  shrinkage.apply(found, noisy.variance, {kOffset, origin});
  CHECK(relative_error(found, noisy.radiance) < 1e-5);
}

TEST_CASE("twice as many tiles leave less noise", "[isa]") {
  WorkerPool pool(2);
  Shrinkage shrinkage(pool);
  const Noisy noisy(61, 83, 0.1f);
  const auto error = [&](ShrinkageEffort effort) {
    Image<float> found = noisy.radiance.clone();
    shrinkage.apply(found, noisy.variance, {kOffset, NoiseOrigin::Sensor, effort});
    return relative_error(found, noisy.clean);
  };
  CHECK(error(ShrinkageEffort::Dense) < 0.985 * error(ShrinkageEffort::On));
}

TEST_CASE("errors that neighbours share are shrunk more than a sensor's own noise") {
  WorkerPool pool(1);
  Shrinkage shrinkage(pool);
  Noisy noisy(48, 64, 0.1f);
  // what is left of texture, in luminance and as red against blue
  const auto texture = [](const Image<float>& picture, bool chroma) {
    double sum = 0;
    for (int y = 1; y < picture.rows(); ++y)
      for (int x = 1; x < picture.cols(); ++x) {
        const auto tone = [&](int v, int u) {
          const double r = std::log(picture.at(0, v, u)), g = std::log(picture.at(1, v, u)),
                       b = std::log(picture.at(2, v, u));
          return chroma ? r - b : r + g + b;
        };
        const double change = tone(y, x) - tone(y, x - 1) - tone(y - 1, x) + tone(y - 1, x - 1);
        sum += change * change;
      }
    return sum;
  };
  Image<float> own = noisy.radiance.clone(), shared = noisy.radiance.clone();
  shrinkage.apply(own, noisy.variance, {kOffset, NoiseOrigin::Sensor});
  shrinkage.apply(shared, noisy.variance, {kOffset, NoiseOrigin::Unknown});
  CHECK(texture(shared, false) < 0.5 * texture(own, false));
  CHECK(texture(shared, true) < 0.5 * texture(own, true));
}

TEST_CASE("every pixel lies in a tile, whatever the size", "[isa]") {
  WorkerPool pool(1);
  Shrinkage shrinkage(pool);
  for (const ShrinkageEffort effort : {ShrinkageEffort::On, ShrinkageEffort::Dense})
    for (int rows = 8; rows < 24; ++rows)
      for (int cols = 8; cols < 16; ++cols) {
        Noisy noisy(rows, cols, 0.1f);
        noisy.variance.fill(0);
        Image<float> found = noisy.radiance.clone();
        shrinkage.apply(found, noisy.variance, {kOffset, NoiseOrigin::Unknown, effort});
        CAPTURE(rows, cols, effort);
        REQUIRE(relative_error(found, noisy.radiance) < 1e-5);
      }
}

TEST_CASE("shrinkage survives radiance of zero, of 10^30, and a picture smaller than a tile", "[isa]") {
  WorkerPool pool(1);
  Shrinkage shrinkage(pool);
  Image<float> radiance(3, 16, 16), variance(3, 16, 16);
  radiance.fill(0), variance.fill(1e10f);
  for (int y = 0; y < 16; ++y) radiance.at(1, y, 7) = 1e30f;
  shrinkage.apply(radiance, variance, {kOffset, NoiseOrigin::Sensor});
  for (const float v : radiance.samples()) REQUIRE((std::isfinite(v) && v >= 0));
  Image<float> tiny(3, 7, 30);
  tiny.fill(0.5f);
  shrinkage.apply(tiny, tiny.clone(), {kOffset, NoiseOrigin::Sensor});
  for (const float v : tiny.samples()) REQUIRE(v == 0.5f);
}
