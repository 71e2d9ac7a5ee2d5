#include "render/shrinkage.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <numbers>

#include "render/vulkan/vulkan_shrinkage.h"

namespace hdrcam {
namespace {

constexpr int kTile = 8, kStep = 4;
constexpr float kMaxLogVariance = 0.25f;

using Tile = std::array<std::array<float, kTile>, kTile>;

// rows are the cosines of one frequency
Tile make_dct() {
  Tile dct{};
  for (std::size_t k = 0; k < kTile; ++k)
    for (std::size_t n = 0; n < kTile; ++n)
      dct[k][n] = static_cast<float>((k != 0 ? std::sqrt(0.25) : std::sqrt(0.125)) *
                                     std::cos(std::numbers::pi * static_cast<double>((2 * n + 1) * k) / 16));
  return dct;
}

Tile transposed(const Tile& a) {
  Tile t{};
  for (std::size_t i = 0; i < kTile; ++i)
    for (std::size_t j = 0; j < kTile; ++j) t[j][i] = a[i][j];
  return t;
}

const Tile kDct = make_dct(), kDctTransposed = transposed(kDct);

// a * b, the inner loop over the columns of b: eight lanes
Tile product(const Tile& a, const Tile& b) {
  Tile out{};
  for (std::size_t i = 0; i < kTile; ++i)
    for (std::size_t k = 0; k < kTile; ++k)
      for (std::size_t j = 0; j < kTile; ++j) out[i][j] += a[i][k] * b[k][j];
  return out;
}

// orthonormal: luminance, red - blue, green against both
constexpr std::array<std::array<float, 3>, 3> kOpponent{
    {{0.57735f, 0.57735f, 0.57735f}, {-0.70711f, 0, 0.70711f}, {0.40825f, -0.81650f, 0.40825f}}};

}  // namespace

Shrinkage::Shrinkage(WorkerPool& pool, GpuDevice* gpu) : pool_(pool) {
  if (gpu == nullptr) return;
  auto made = VulkanShrinkage::make(*gpu);
  if (made)
    gpu_ = std::move(*made);
  else
    give_up(made.error());
}

Shrinkage::~Shrinkage() = default;

void Shrinkage::give_up(const Error& why) {
  spdlog::warn("shrinkage goes on with the processor: {}", why.message);
  gpu_.reset();
}

void Shrinkage::apply(Image<float>& radiance, const Image<float>& variance, float offset) {
  if (radiance.rows() < kTile || radiance.cols() < kTile) return;
  if (gpu_ != nullptr) {
    const Result<void> done = gpu_->apply(radiance, variance, offset);
    if (done) return;
    give_up(done.error());
  }
  apply_here(radiance, variance, offset);
}

void Shrinkage::apply_here(Image<float>& radiance, const Image<float>& variance, float offset) {
  const int rows = radiance.rows(), cols = radiance.cols();
  for (auto* image : {&opponent_, &noise_, &sum_, &weight_}) image->reshape_like(radiance);

  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        std::array<float, 3> log_radiance, log_variance;
        for (int c = 0; c < 3; ++c) {
          const float a = std::max(0.f, radiance.at(c, y, x)) + offset;
          log_radiance[static_cast<std::size_t>(c)] = std::log(a);
          log_variance[static_cast<std::size_t>(c)] =
              std::min(kMaxLogVariance, variance.at(c, y, x) / (a * a));
        }
        for (int c = 0; c < 3; ++c) {
          const auto& t = kOpponent[static_cast<std::size_t>(c)];
          opponent_.at(c, y, x) = t[0] * log_radiance[0] + t[1] * log_radiance[1] + t[2] * log_radiance[2];
          noise_.at(c, y, x) =
              t[0] * t[0] * log_variance[0] + t[1] * t[1] * log_variance[1] + t[2] * t[2] * log_variance[2];
          sum_.at(c, y, x) = 0;
          weight_.at(c, y, x) = 0;
        }
      }
  });

  // Tile rows 2*kStep apart do not overlap: two passes of independent rows, then the last row if it is out of
  // step.
  const int tile_rows = (rows - kTile) / kStep + 1;
  for (int parity = 0; parity < 2; ++parity)
    pool_.for_each((tile_rows + 1 - parity) / 2 * 3,
                   [&](int i) { shrink_tile_row(i % 3, (i / 3 * 2 + parity) * kStep); });
  if ((rows - kTile) % kStep != 0) pool_.for_each(3, [&](int c) { shrink_tile_row(c, rows - kTile); });

  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        std::array<float, 3> o;
        for (int c = 0; c < 3; ++c) o[static_cast<std::size_t>(c)] = sum_.at(c, y, x) / weight_.at(c, y, x);
        for (int c = 0; c < 3; ++c) {
          const auto k = static_cast<std::size_t>(c);
          const float log_radiance = kOpponent[0][k] * o[0] + kOpponent[1][k] * o[1] + kOpponent[2][k] * o[2];
          radiance.at(c, y, x) = std::max(0.f, std::exp(log_radiance) - offset);
        }
      }
  });
}

void Shrinkage::shrink_tile_row(int channel, int y0) {
  const int cols = opponent_.cols();
  for (int x0 = 0;;) {
    Tile pixels;
    float noise = 0;
    for (int i = 0; i < kTile; ++i)
      for (int j = 0; j < kTile; ++j) {
        pixels[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
            opponent_.at(channel, y0 + i, x0 + j);
        noise += noise_.at(channel, y0 + i, x0 + j);
      }
    noise *= 1.f / (kTile * kTile);
    Tile spectrum = product(product(kDct, pixels), kDctTransposed);
    float energy = 1;  // of the gains; the mean is not shrunk
    for (std::size_t i = 0; i < kTile; ++i)
      for (std::size_t j = 0; j < kTile; ++j) {
        if (i == 0 && j == 0) continue;
        const float power = spectrum[i][j] * spectrum[i][j];
        const float gain = std::max(0.f, (power - 1.5f * noise) / (power + 1e-12f));
        spectrum[i][j] *= gain;
        energy += gain * gain;
      }
    const Tile smooth = product(product(kDctTransposed, spectrum), kDct);
    const float weight = 1 / (energy * (noise + 1e-6f));
    for (int i = 0; i < kTile; ++i) {
      float *sum = sum_.row(channel, y0 + i) + x0, *total = weight_.row(channel, y0 + i) + x0;
      for (int j = 0; j < kTile; ++j) {
        sum[j] += weight * smooth[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
        total[j] += weight;
      }
    }
    if (x0 == cols - kTile) break;
    x0 = std::min(x0 + kStep, cols - kTile);
  }
}

}  // namespace hdrcam
