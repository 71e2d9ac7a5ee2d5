// What an emitted frame says of its pixels: where each comes from, and how uncertain it is.
#include "render/emission.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "online/mu_law.h"
#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr float kWhite = 4;
constexpr std::array<float, 3> kLight{0.1f, 0.2f, 0.4f};

// One row of pixels of one light, each with shares and variances of its own.
struct JudgedRow {
  struct Pixel {
    float own, later;
    std::array<float, 3> variance;
    Provenance from, without_later;
  };
  std::vector<Pixel> pixels;
  WorkerPool pool{1};
  ExposedFrame input;
  RadianceEstimate state;
  Image<float> own, later;
  HdrFrame frame;

  explicit JudgedRow(std::vector<Pixel> row) : pixels(std::move(row)) {
    const int cols = static_cast<int>(pixels.size());
    state = {Image<float>(3, 1, cols), Image<float>(3, 1, cols)};
    own = Image<float>(1, 1, cols), later = Image<float>(1, 1, cols);
    for (int x = 0; x < cols; ++x) {
      const Pixel& pixel = pixels[static_cast<std::size_t>(x)];
      own.at(0, 0, x) = pixel.own, later.at(0, 0, x) = pixel.later;
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        state.radiance.at(c, 0, x) = kLight[channel], state.variance.at(c, 0, x) = pixel.variance[channel];
      }
    }
    input.facts.exposure_s = 0.008, input.facts.analogue_gain = 2;
  }
  void emit(const Image<float>* later_share) {
    FrameEstimate estimate = test::estimate_by_state(input, state, own);
    estimate.later_share = later_share;
    estimate.budget.shrinkage = ShrinkageEffort::Off;
    estimate.white = kWhite, estimate.unseen_variance = unseen_variance_from(kWhite);
    estimate.reference_exposure = 0.004;
    Emission(pool).render(estimate, frame);
  }
};

}  // namespace

TEST_CASE("a pixel is of whom it has most, and a bound where one of its channels was never seen unclipped") {
  const float unseen = unseen_variance_from(kWhite), nearly = 0.99f * unseen;
  using enum Provenance;
  JudgedRow row({{0.8f, 0, {1e-4f, 1e-4f, 1e-4f}, Own, Own},
                 {0.4f, 0, {1e-4f, 1e-4f, 1e-4f}, Carried, Carried},
                 {0.8f, 0.3f, {1e-4f, 1e-4f, 1e-4f}, Own, Own},      // .56 of the whole
                 {0.6f, 0.3f, {1e-4f, 1e-4f, 1e-4f}, Carried, Own},  // .42
                 {0.9f, 0.6f, {1e-4f, 1e-4f, 1e-4f}, LookAhead, Own},
                 {0.9f, 0, {1e-4f, 1e-4f, unseen}, Bound, Bound},
                 {0.9f, 0.6f, {unseen, 1e-4f, 1e-4f}, Bound, Bound},
                 {0.9f, 0, {1e-4f, kUnseenVariance, 1e-4f}, Bound, Bound},
                 {0.9f, 0, {nearly, nearly, nearly}, Own, Own}});
  row.emit(&row.later);
  for (std::size_t x = 0; x < row.pixels.size(); ++x) {
    CAPTURE(x);
    CHECK(row.frame.provenance.samples()[x] == static_cast<std::uint8_t>(row.pixels[x].from));
  }
  row.emit(nullptr);
  for (std::size_t x = 0; x < row.pixels.size(); ++x) {
    CAPTURE(x);
    CHECK(row.frame.provenance.samples()[x] == static_cast<std::uint8_t>(row.pixels[x].without_later));
  }
}

TEST_CASE(
    "sigma is the deviation of the logarithm of what is seen of a radiance, all channels alike, up to 10") {
  JudgedRow row({{1, 0, {1e-6f, 4e-6f, 16e-6f}, {}, {}},
                 {1, 0, {1e-2f, 0, 0}, {}, {}},
                 {1, 0, {0, 0, 1e-2f}, {}, {}},
                 {1, 0, {0, 0, 0}, {}, {}},
                 {1, 0, {1e-4f, kUnseenVariance, 1e-4f}, {}, {}}});
  row.emit(nullptr);
  for (std::size_t x = 0; x < row.pixels.size(); ++x) {
    double mean2 = 0;
    for (std::size_t c = 0; c < 3; ++c)
      mean2 += static_cast<double>(row.pixels[x].variance[c]) /
               std::pow(static_cast<double>(kLight[c] + barely_visible(kWhite)), 2) / 3;
    CAPTURE(x);
    CHECK(row.frame.sigma.samples()[x] == Approx(std::min(10.0, std::sqrt(mean2))).margin(1e-6));
  }
  CHECK(row.frame.exposure == Approx(4));  // 8 ms at gain 2, of 4 ms
  CHECK(row.frame.white == kWhite);
}
