#include "online/state/fusion_kernels.h"

#include <array>
#include <cmath>
#include <vector>

#include "capture/clip_policy.h"
#include "hal/core/smooth_step.h"
#include "online/state/exposure_blur_kernels.h"
#include "online/state/exposure_tables.h"
#include "tests/support/numbers.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::Numbers;
using test::Row;

namespace {

constexpr std::array<int, 6> kSizes{1, 7, 8, 63, 64, 331};  // around a vector and around a block
constexpr float kTiny = 1e-20f;

void require_near(const Row& found, const Row& expected, float relative) {
  for (std::size_t x = 0; x < expected.size(); ++x) {
    INFO("pixel " << x << " of " << expected.size());
    REQUIRE(found[x] == Approx(expected[x]).epsilon(relative).margin(1e-7));
  }
}

const ExposureTables& tables() {
  static const ExposureTables kTables(Response::gamma(2.2f), {}, 0.5f);
  return kTables;
}
SampleVariances noise() { return {tables().variances(1).data(), tables().exposure()}; }

}  // namespace

TEST_CASE("samples are read from the tables, and fade where fusion.h says", "[isa]") {
  Numbers numbers(5);
  for (const int n : kSizes) {
    const auto size = static_cast<std::size_t>(n);
    Row codes = numbers.between(-3, 258, n), brightest = numbers.between(0, 255, n);
    codes[0] = 255;
    Row radiance(size), weight(size), comparable(size);
    fusion_kernels().sample({codes.data(), brightest.data(), tables().radiances(1).data(), radiance.data(),
                             weight.data(), comparable.data()},
                            n);
    Row as_read(size), as_weighed(size), as_compared(size);
    for (std::size_t x = 0; x < size; ++x) {
      using namespace clip_policy;
      const float bright = std::max(codes[x], brightest[x]);
      as_read[x] = tables().radiance(1, codes[x]);
      as_weighed[x] = 1 - smooth_step(kFadeBegin, kFadeEnd, bright);
      as_compared[x] = (1 - smooth_step(kCompareFadeBegin, kCompareFadeEnd, bright)) *
                       smooth_step(kCompareDarkBegin, kCompareDarkEnd, codes[x]);
    }
    require_near(radiance, as_read, 1e-5f);
    require_near(weight, as_weighed, 1e-4f);
    require_near(comparable, as_compared, 1e-4f);
  }
}

TEST_CASE("the state is recorded as the camera would: blurred, clipped, through the response", "[isa]") {
  Numbers numbers(6);
  for (const int n : kSizes)
    for (const bool blurred : {false, true}) {
      std::vector<Row> radiance, blur;
      RecordedRow row{
          .radiance = {}, .blur = {}, .codes = {}, .exposure = tables().exposure(), .gray = nullptr};
      for (int c = 0; c < 3; ++c) {
        radiance.push_back(numbers.between(-0.1f, c == 0 ? 3.f : 0.1f, n));
        blur.push_back(numbers.between(-0.1f, 0.1f, n));
      }
      for (int c = 0; c < 3; ++c) {
        row.radiance[c] = radiance[static_cast<std::size_t>(c)].data();
        if (blurred) row.blur[c] = blur[static_cast<std::size_t>(c)].data();
        row.codes[c] = tables().codes(c).data();
      }
      Row gray(static_cast<std::size_t>(n)), expected(gray.size());
      row.gray = gray.data();
      fusion_kernels().record(row, n);
      for (std::size_t x = 0; x < gray.size(); ++x)
        for (std::size_t c = 0; c < 3; ++c)
          expected[x] += tables().code(static_cast<int>(c), radiance[c][x] + (blurred ? blur[c][x] : 0)) / 3;
      require_near(gray, expected, 1e-4f);
    }
}

TEST_CASE("the gate compares what both know, and takes clipped samples for bounds", "[isa]") {
  Numbers numbers(5);
  for (const int n : kSizes) {
    const auto size = static_cast<std::size_t>(n);
    constexpr float kKnown = 1, kRelative2 = 0.01f, kTexture2 = 0.06f, kBlur = 0.1f;
    const Row state = numbers.between(0, 1, n), variance = numbers.between(0, 2, n);
    const Row mean = numbers.between(0, 1, n), contrast = numbers.between(0, 0.1f, n);
    const Row sample = numbers.between(0, 1, n), comparable = numbers.between(0, 1, n);
    const Row blur = numbers.between(-0.1f, 0.1f, n);
    Row chi2(size, 0.5f), covered(size, 0.25f), as_chi2 = chi2, as_covered = covered;
    fusion_kernels().compare(
        {state.data(), variance.data(), mean.data(), contrast.data(), sample.data(), comparable.data(),
         blur.data(), noise(), kKnown, kRelative2, kTexture2, kBlur, chi2.data(), covered.data()},
        n);
    for (std::size_t x = 0; x < size; ++x) {
      const float mask = variance[x] < kKnown ? comparable[x] : 0;
      const float off = state[x] + blur[x] - sample[x], average = 0.5f * (state[x] + sample[x]);
      as_chi2[x] += mask * off * off /
                    (variance[x] + tables().variance(1, mean[x]) + kRelative2 * average * average +
                     kTexture2 * contrast[x] + kBlur * blur[x] * blur[x] + kTiny);
      as_covered[x] += mask;
    }
    require_near(chi2, as_chi2, 1e-4f);
    require_near(covered, as_covered, 1e-5f);

    const Row trust = numbers.between(0, 1, n), bright = numbers.between(0.5f, 3, n);
    const Row weight = numbers.between(0, 0.1f, n);
    Row gate(size), as_gated(size);
    GatedRow row{chi2.data(), covered.data(), trust.data(), {}, {}, {}, 1.5f, 1.5f, 0.002f, gate.data()};
    for (int c = 0; c < 3; ++c)
      row.state[c] = state.data(), row.sample[c] = c == 1 ? bright.data() : sample.data(),
      row.weight[c] = weight.data();
    fusion_kernels().gate(row, n);
    for (std::size_t x = 0; x < size; ++x) {
      const float excess = std::max(0.f, chi2[x] / (covered[x] + 0.05f) - 1.5f);
      float bound = 1;
      for (const float r : {sample[x], bright[x]}) {
        const float below = std::max(0.f, 1 - state[x] / (0.9f * r + kTiny)) / 0.15f;
        if (weight[x] < 0.05f) bound = std::min(bound, std::exp(-below * below));
      }
      const float agreement = 1 - std::min(1.f, covered[x]) * 0.998f * (1 - std::exp(-excess / 1.5f));
      as_gated[x] = trust[x] * agreement * (0.002f + 0.998f * bound);
    }
    require_near(gate, as_gated, 1e-4f);
  }
}

namespace {

constexpr float ringing_of(bool whole) { return whole ? 0.7f : 0; }

// What is known of one pixel.
struct UpdatedPixel {
  float state, variance, share;  // share: of the sample, in the mean of the channels
};
// What a frame shows there. whole: nothing gates it or bounds it. starts: it is the first one.
struct PixelSample {
  float sample, weight, mean, blur, gate, extra;
  bool whole, starts;

  float ringing() const { return ringing_of(whole); }
};
constexpr float kUnseenFrom = 1, kRelativeNoise2 = 4e-4f, kBlurVariance = 1, kUnknownBlurVariance = 8,
                kLeastRadiance = 0.2f;

// The update, pixel by pixel: fusion.h has the words for it.
UpdatedPixel updated(UpdatedPixel pixel, const PixelSample& seen) {
  const float exposure = tables().exposure();
  float &s = pixel.state, &v = pixel.variance;
  const float sure = s + seen.blur - (v < kUnseenFrom ? 2 * std::sqrt(v) : 0);
  const float clipped = smooth_step(1.25f, 2.5f, sure * exposure);
  const float weighs = std::max(0.f, seen.weight - 3 * seen.ringing() * clipped * (1 - seen.weight));
  const bool other =
      !seen.whole && v >= kUnseenFrom && s * exposure >= 0.98f && seen.sample * exposure < 0.5f;
  const float guessed = std::max({s, seen.sample, kLeastRadiance});
  if (!seen.starts && !other && v >= kUnseenFrom && weighs >= 0.05f) v = std::min(v, guessed * guessed);
  const float blur2 = seen.blur * seen.blur;
  float doubt = tables().variance(1, seen.mean) + kRelativeNoise2 * seen.mean * seen.mean,
        taken = seen.sample;
  if (v < kUnseenFrom) {
    taken = std::max(0.f, taken - seen.blur * blur2 / (blur2 + v + kTiny));
    doubt += kBlurVariance * blur2;
  } else {
    doubt += kUnknownBlurVariance * blur2;
  }
  if (!seen.whole) doubt += seen.extra;
  const float w = other ? 0 : weighs * (seen.whole ? 1 : seen.gate) / (doubt + kTiny);
  const float before = 1 / (v + kTiny);
  if ((v < kUnseenFrom && !other) || w > 1e-5f / (seen.mean * seen.mean + kTiny)) {
    s = (s * before + taken * w) / (before + w);
    v = 1 / (before + w);
    pixel.share += w / (before + w) / 3;
  } else {
    s = std::max(s, seen.sample);
  }
  return pixel;
}

}  // namespace

TEST_CASE("the update is the inverse-variance mean, or the larger bound of what nobody knows", "[isa]") {
  Numbers numbers(5);
  for (const int n : kSizes)
    for (const auto& [whole, starts] :
         {std::pair(false, false), std::pair(true, false), std::pair(true, true)}) {
      const auto size = static_cast<std::size_t>(n);
      const Row state = numbers.between(0, starts ? 1 : 6, n), variance = numbers.between(0, 2, n);
      const Row sample = numbers.between(0, 1, n), mean = numbers.between(0.01f, 1, n);
      const Row blur = numbers.between(-0.1f, 0.1f, n), gate = numbers.between(0, 1, n);
      const Row extra = numbers.between(0, 0.1f, n);
      Row weight = numbers.between(-1, 1, n), share(size, 0.1f);
      for (float& w : weight) w = std::max(0.f, w);
      Row as_state(size), as_variance(size), as_shared(size), new_state(size), new_variance(size);
      for (std::size_t x = 0; x < size; ++x) {
        const UpdatedPixel pixel =
            updated({state[x], variance[x], share[x]},
                    {sample[x], weight[x], mean[x], blur[x], gate[x], extra[x], whole, starts});
        as_state[x] = pixel.state, as_variance[x] = pixel.variance, as_shared[x] = pixel.share;
      }
      fusion_kernels().update({.state = state.data(),
                               .variance = variance.data(),
                               .sample = sample.data(),
                               .weight = weight.data(),
                               .mean = mean.data(),
                               .blur = blur.data(),
                               .gate = whole ? nullptr : gate.data(),
                               .extra = whole ? nullptr : extra.data(),
                               .noise = noise(),
                               .unseen_from = kUnseenFrom,
                               .relative2 = kRelativeNoise2,
                               .blur_variance = kBlurVariance,
                               .unknown_blur_variance = kUnknownBlurVariance,
                               .least = kLeastRadiance,
                               .ringing = ringing_of(whole),
                               .bounded = !whole,
                               .starts = starts,
                               .new_state = new_state.data(),
                               .new_variance = new_variance.data(),
                               .share = share.data()},
                              n);
      require_near(new_state, as_state, 1e-4f);
      require_near(new_variance, as_variance, 1e-4f);
      require_near(share, as_shared, 1e-4f);
    }
}

TEST_CASE("a sample stands in where the state knows nothing", "[isa]") {
  Numbers numbers(6);
  for (const int n : kSizes) {
    const auto size = static_cast<std::size_t>(n);
    const Row state = numbers.between(0, 1, n), sample = numbers.between(1, 2, n);
    const Row variance = numbers.between(0, 2, n);
    Row out(size);
    fusion_kernels().stand_in({state.data(), variance.data(), sample.data(), 1, out.data()}, n);
    for (std::size_t x = 0; x < size; ++x) CHECK(out[x] == (variance[x] < 1 ? state[x] : sample[x]));
  }
}

TEST_CASE("a warp adds variance by its length and by its fraction of a pixel", "[isa]") {
  Numbers numbers(5);
  for (const int n : kSizes) {
    const auto size = static_cast<std::size_t>(n);
    Row dx = numbers.between(-5, 5, n);
    const Row dy = numbers.between(-0.5f, 0.5f, n);
    dx[0] = -2;
    Row variance(size), expected(size);
    fusion_kernels().warp_variance({dx.data(), dy.data(), 0.16f, variance.data()}, n);
    for (std::size_t x = 0; x < size; ++x) {
      const float fx = dx[x] - std::floor(dx[x]), fy = dy[x] - std::floor(dy[x]);
      const float between = 2 * (fx * (1 - fx) + fy * (1 - fy));
      expected[x] = 0.16f * (0.3f * std::min(1.f, std::hypot(dx[x], dy[x])) + 0.7f * between);
    }
    require_near(variance, expected, 1e-3f);
  }
}

TEST_CASE("textures are doubted by a share of their contrast and by what processing hides of it", "[isa]") {
  Numbers numbers(5);
  for (const int n : kSizes) {
    const auto size = static_cast<std::size_t>(n);
    constexpr float kShare = 0.05f;
    Row mean = numbers.between(-0.1f, 2.5f, n), contrast = numbers.between(0, 0.01f, n), expected(size);
    contrast[0] = 0;
    for (std::size_t x = 0; x < size; ++x)
      expected[x] = kShare * contrast[x] + tables().hidden_texture(1, mean[x], contrast[x]);
    Row doubt = contrast;
    fusion_kernels().doubt_textures(
        {mean.data(), {tables().hidden(1).data(), tables().exposure()}, kShare, doubt.data()}, n);
    require_near(doubt, expected, 1e-4f);
  }
}

TEST_CASE("what is carried grows uncertain with time, warp and doubt, but never more than a guess is",
          "[isa]") {
  Numbers numbers(5);
  for (const int n : kSizes) {
    const auto size = static_cast<std::size_t>(n);
    constexpr float kGrowth = 1.05f, kRelative2 = 1e-4f, kFloor = 0.1f, kKnown = 1, kUnseen = 100,
                    kLeast = 0.1f;
    const Row state = numbers.between(0, 1, n), sample = numbers.between(0, 1, n);
    const Row contrast = numbers.between(0, 1, n), per_contrast = numbers.between(0, 0.2f, n);
    Row variance = numbers.between(-1, 1.2f, n), gate = numbers.between(0, 1, n),
        weight = numbers.between(-1, 1, n);
    for (std::size_t x = 0; x < size; ++x) variance[x] = x % 5 == 0 ? kUnseen : std::max(variance[x], 1e-4f);
    Row found(size), expected(size);
    fusion_kernels().age(
        {state.data(), variance.data(), gate.data(), sample.data(), weight.data(), contrast.data(),
         per_contrast.data(), kGrowth, kRelative2, kFloor, kKnown, kUnseen, kLeast, found.data()},
        n);
    for (std::size_t x = 0; x < size; ++x) {
      const float aged =
          variance[x] * kGrowth + kRelative2 * state[x] * state[x] + per_contrast[x] * contrast[x];
      const float lost = gate[x] <= kFloor ? kUnseen : std::min(kUnseen, aged / gate[x]);
      const float guessed = std::max({state[x], sample[x], kLeast});
      const float guess = aged < kKnown ? std::max(aged, guessed * guessed) : kUnseen;
      expected[x] = weight[x] < 0.05f ? lost : std::min(lost, guess);
    }
    require_near(found, expected, 1e-4f);
  }
}

TEST_CASE("the blur of an exposure is the mean over its instants, less than .6 pixels is none", "[isa]") {
  Numbers numbers(5);
  constexpr int kRows = 9, kCols = 75;
  constexpr float kFraction = 0.7f;
  const Row picture = numbers.between(0, 1, 3 * kRows * kCols);
  struct Motion {
    float dx, dy, apart;  // apart: between neighbours
  };
  for (const auto& [dx, dy, apart] :
       {Motion{0.4f, 0, 0}, {2.3f, -1.2f, 0}, {-30, 4, 0}, {200, 0, 0}, {2.3f, -1.2f, 5}}) {
    const Row u = numbers.between(dx - apart, dx + apart, kRows * kCols);
    const Row v = numbers.between(dy - apart, dy + apart, kRows * kCols);
    Row difference(picture.size(), 7), expected(picture.size());
    exposure_blur_kernels().blur(
        {picture.data(), u.data(), v.data(), kFraction, difference.data(), 3, kRows, kCols, 0, kRows});
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) {
          const float* plane = picture.data() + c * kRows * kCols;
          const auto own = static_cast<std::size_t>(y * kCols + x);
          const auto at = static_cast<std::size_t>(c * kRows * kCols) + own;
          const float length = std::hypot(u[own], v[own]) * kFraction;
          const int count =
              length < 0.6f
                  ? 0
                  : std::clamp(static_cast<int>(std::ceil(0.7f * std::min(length, 64.f))) + 1, 3, 9);
          float sum = 0;
          for (int k = 0; k < count; ++k) {
            const float instant =
                kFraction * ((static_cast<float>(k) + 0.5f) / static_cast<float>(count) - 0.5f);
            const auto along = [](int from, float by, int size) {
              return std::clamp(static_cast<float>(from) + by, 0.f, static_cast<float>(size - 1));
            };
            // it moves as the place does where it is seen
            const auto seen =
                static_cast<std::size_t>(static_cast<int>(along(y, instant * v[own], kRows) + 0.5f) * kCols +
                                         static_cast<int>(along(x, instant * u[own], kCols) + 0.5f));
            const float sx = along(x, instant * u[seen], kCols), sy = along(y, instant * v[seen], kRows);
            const int ix = std::min(static_cast<int>(sx), kCols - 2),
                      iy = std::min(static_cast<int>(sy), kRows - 2);
            const float fx = sx - static_cast<float>(ix), fy = sy - static_cast<float>(iy);
            const float* p = plane + iy * kCols + ix;
            sum += (1 - fy) * ((1 - fx) * p[0] + fx * p[1]) + fy * ((1 - fx) * p[kCols] + fx * p[kCols + 1]);
          }
          expected[at] = count == 0 ? 0 : sum / static_cast<float>(count) - picture[at];
        }
    for (std::size_t i = 0; i < expected.size(); ++i) {
      INFO("motion " << dx << ", " << dy << ", apart " << apart << "; sample " << i);
      REQUIRE(difference[i] == Approx(expected[i]).margin(2e-5));
    }
  }
}
