// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// A row of a tile is one vector of eight floats.
#include "render/shrinkage_kernels.h"

#include <cstddef>

#include "hal/core/lane_functions.h"
#include "hal/core/lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

inline float total(Lanes v) { return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])); }
inline Lanes positive(Lanes v) { return v > 0 ? v : Lanes{}; }

constexpr float kOpponent[3][3] = {
    {kOfLuminance, kOfLuminance, kOfLuminance}, {-kOfRedBlue, 0, kOfRedBlue}, {kOfBoth, -kOfGreen, kOfBoth}};

void to_opponent(const OpponentRow& row, int n) {
  constexpr int kBlock = 64;
  const float offset = row.offset;
  // whole rows: for a block the compiler writes string instructions, which take longer to begin than to end
  for (int c = 0; c < 3; ++c) {
    __builtin_memset(row.sum[c], 0, sizeof(float) * static_cast<std::size_t>(n));
    __builtin_memset(row.weight[c], 0, sizeof(float) * static_cast<std::size_t>(n));
  }
  float logs[3][kBlock], variances[3][kBlock];
  for (int x0 = 0; x0 < n; x0 += kBlock) {
    const int count = n - x0 < kBlock ? n - x0 : kBlock;
    for (int c = 0; c < 3; ++c) {
      const float *in = row.radiance[c] + x0, *v = row.variance[c] + x0;
      for (int x = 0; x < count; ++x) {
        const float a = (in[x] > 0 ? in[x] : 0) + offset, relative = v[x] / (a * a);
        logs[c][x] = log_of(a);
        variances[c][x] = relative < kMaxLogVariance ? relative : kMaxLogVariance;
      }
    }
    for (int c = 0; c < 3; ++c) {
      const float* t = kOpponent[c];
      const float t0 = t[0] * t[0], t1 = t[1] * t[1], t2 = t[2] * t[2];
      float *o = row.opponent[c] + x0, *s = row.noise[c] + x0;
      for (int x = 0; x < count; ++x) o[x] = t[0] * logs[0][x] + t[1] * logs[1][x] + t[2] * logs[2][x];
      for (int x = 0; x < count; ++x)
        s[x] = t0 * variances[0][x] + t1 * variances[1][x] + t2 * variances[2][x];
    }
  }
}

void to_radiance(const SmoothRow& row, int n) {
  constexpr int kBlock = 64;
  const float offset = row.offset;
  float o[3][kBlock];
  for (int x0 = 0; x0 < n; x0 += kBlock) {
    const int count = n - x0 < kBlock ? n - x0 : kBlock;
    for (int c = 0; c < 3; ++c) {
      const float *sum = row.sum[c] + x0, *weight = row.weight[c] + x0;
      for (int x = 0; x < count; ++x) o[c][x] = sum[x] / weight[x];
    }
    for (int c = 0; c < 3; ++c) {
      float* out = row.radiance[c] + x0;
      for (int x = 0; x < count; ++x) {
        const float value =
            exp_of(kOpponent[0][c] * o[0][x] + kOpponent[1][c] * o[1][x] + kOpponent[2][c] * o[2][x]) -
            offset;
        out[x] = value > 0 ? value : 0;
      }
    }
  }
}

// Rows are the cosines of one frequency.
constexpr float c1 = kCos1, c2 = kCos2, c3 = kCos3, c4 = kCos4, c5 = kCos5, c6 = kCos6, c7 = kCos7;
constexpr float kDct[8][8] = {{c4, c4, c4, c4, c4, c4, c4, c4},     {c1, c3, c5, c7, -c7, -c5, -c3, -c1},
                              {c2, c6, -c6, -c2, -c2, -c6, c6, c2}, {c3, -c7, -c1, -c5, c5, c1, c7, -c3},
                              {c4, -c4, -c4, c4, c4, -c4, -c4, c4}, {c5, -c1, c7, c3, -c3, -c7, c1, -c5},
                              {c6, -c2, c2, -c6, -c6, c2, -c2, c6}, {c7, -c5, c3, -c1, c1, -c3, c5, -c7}};

struct Tile {
  Lanes row[8];
};
// The transform of the columns; all eight at once, a lane each.
inline Tile forward(const Tile& a) {
  Tile out;
  // even frequencies see the sums of mirrored rows, odd ones the differences
  Lanes sums[4], differences[4];
  for (int k = 0; k < 4; ++k) sums[k] = a.row[k] + a.row[7 - k], differences[k] = a.row[k] - a.row[7 - k];
  for (int k = 0; k < 8; ++k) {
    const Lanes* part = k % 2 == 0 ? sums : differences;
    out.row[k] = kDct[k][0] * part[0] + kDct[k][1] * part[1] + kDct[k][2] * part[2] + kDct[k][3] * part[3];
  }
  return out;
}
inline Tile backward(const Tile& a) {
  Tile out;
  for (int n = 0; n < 4; ++n) {
    const Lanes even =
        kDct[0][n] * a.row[0] + kDct[2][n] * a.row[2] + kDct[4][n] * a.row[4] + kDct[6][n] * a.row[6];
    const Lanes odd =
        kDct[1][n] * a.row[1] + kDct[3][n] * a.row[3] + kDct[5][n] * a.row[5] + kDct[7][n] * a.row[7];
    out.row[n] = even + odd, out.row[7 - n] = even - odd;
  }
  return out;
}
inline Tile transposed(const Tile& a) {
  Lanes s[8], t[8];
  for (int k = 0; k < 4; ++k) {
    s[2 * k] = __builtin_shufflevector(a.row[2 * k], a.row[2 * k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    s[2 * k + 1] = __builtin_shufflevector(a.row[2 * k], a.row[2 * k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int k = 0; k < 8; k += 4)
    for (int j = 0; j < 2; ++j) {
      t[k + j] = __builtin_shufflevector(s[k + j], s[k + 2 + j], 0, 1, 8, 9, 4, 5, 12, 13);
      t[k + 2 + j] = __builtin_shufflevector(s[k + j], s[k + 2 + j], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  Tile out;
  for (int j = 0; j < 4; ++j) {
    out.row[j] = __builtin_shufflevector(t[j], t[4 + j], 0, 1, 2, 3, 8, 9, 10, 11);
    out.row[4 + j] = __builtin_shufflevector(t[j], t[4 + j], 4, 5, 6, 7, 12, 13, 14, 15);
  }
  return out;
}

void shrink(const TileRow& row) {
  const float *opponent = row.opponent, *noise = row.noise, *thresholds = row.thresholds;
  float *sum = row.sum, *weight = row.weight;
  const int cols = row.cols, last = cols - kShrinkageTile;
  for (int x0 = row.first < last ? row.first : last;;) {
    Tile pixels;
    Lanes noises{};
    for (int i = 0; i < 8; ++i) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) * cols + x0;
      pixels.row[i] = load(opponent + at);
      noises += load(noise + at);
    }
    const float mean_noise = total(noises) / 64;
    Tile spectrum = forward(transposed(forward(pixels)));  // stands transposed
    const float mean = spectrum.row[0][0];                 // is kept whole
    spectrum.row[0][0] = 0;
    Lanes energies{};  // of the gains
    for (int i = 0; i < 8; ++i) {
      const Lanes power = spectrum.row[i] * spectrum.row[i];
      const Lanes threshold = mean_noise * load(thresholds + kShrinkageTile * i);
      const Lanes gain = positive((power - threshold) / (power + kLeastPower));
      spectrum.row[i] *= gain;
      energies += gain * gain;
    }
    spectrum.row[0][0] = mean;
    const float share = 1 / ((1 + total(energies)) * (mean_noise + kLeastNoise));
    const Tile smooth = backward(transposed(backward(spectrum)));
    for (int i = 0; i < 8; ++i) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) * cols + x0;
      store(sum + at, load(sum + at) + share * smooth.row[i]);
      store(weight + at, load(weight + at) + share);
    }
    if (x0 == last) break;
    x0 = x0 + kShrinkageStep < last ? x0 + kShrinkageStep : last;
  }
}

}  // namespace

extern const ShrinkageKernels kShrinkageKernels;
const ShrinkageKernels kShrinkageKernels{&to_opponent, &shrink, &to_radiance};

}  // namespace hdrcam::HDRCAM_TARGET
