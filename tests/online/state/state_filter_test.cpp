#include "online/state/state_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/moving_scene.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::exposed;

namespace {

const float kUnseen = unseen_variance_from(4);

}  // namespace

TEST_CASE("frames of a still scene add up: the error falls and the variance says by how much") {
  test::MovingScene scene;
  scene.drift_px = scene.disc_px = 0;
  scene.full_well = 400, scene.read_noise = 6;
  scene.exposures_s = {0.004};
  WorkerPool pool(2);
  const Response response = Response::gamma(scene.gamma);
  NoiseModel noise;
  noise.full_well = 400, noise.read_noise = 6, noise.code_noise = 0;
  StateFilter filter({}, scene.rows, scene.cols, pool);
  struct Sums {
    double square = 0, variance = 0;  // of radiance, of pixels that no frame clips
  };
  const auto sums = [&] {
    Sums seen;
    for (int y = 0; y < scene.rows; ++y)
      for (int x = 0; x < scene.cols; ++x) {
        const double truth = scene.radiance(0, 1, x, y);
        if (truth > 0.5) continue;
        const double error = static_cast<double>(filter.state().radiance.at(1, y, x)) - truth;
        seen.square += error * error;
        seen.variance += static_cast<double>(filter.state().variance.at(1, y, x));
      }
    return seen;
  };
  Sums first, last;
  for (int i = 0; i < 12; ++i) {
    const auto frame = exposed(scene.frame(i), i);
    const ExposureTables tables(response, noise, frame.exposure);
    if (i == 0)
      filter.restart({frame, tables, kUnseen});
    else
      filter.advance({frame, tables, kUnseen}, test::uniform_flow(scene.rows, scene.cols));
    (i == 0 ? first : last) = sums();
  }
  INFO("squared error " << first.square << " -> " << last.square << ", claimed " << first.variance << " -> "
                        << last.variance);
  CHECK(last.square < 0.3 * first.square);
  CHECK(last.variance < 0.3 * first.variance);
  for (const Sums& claim : {first, last}) {
    CHECK(claim.square > 0.4 * claim.variance);
    CHECK(claim.square < 1.6 * claim.variance);
  }
}

TEST_CASE("what is known is carried along the motion, its variance with it, and what is not stays unknown") {
  constexpr int kRows = 32, kCols = 64;
  constexpr float kSeen = 2, kBound = 1, kVariance = 0.01f;
  struct Step {
    int dx, dy;  // pixels, to where a pixel was
  };
  const Step step = GENERATE(Step{-8, 5}, Step{11, -3});
  const auto known = [](int x, int y) { return x < kCols / 2 && y < kRows / 2; };
  WorkerPool pool(2);
  RadianceState before{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                       Image<float>(1, kRows, kCols)};
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        before.radiance.at(c, y, x) = known(x, y) ? kSeen : kBound;
        before.variance.at(c, y, x) = known(x, y) ? kVariance : kUnseenVariance;
      }
  ExposedFrame clipped;  // tells no more than that all is at least as bright as the bound
  clipped.index = 1;
  clipped.codes = Image<float>(3, kRows, kCols);
  clipped.codes.fill(kMaxCode);
  const ExposureTables tables(Response::gamma(2.2f), {}, 1);
  const StateOptions options;
  StateFilter filter(options, kRows, kCols, pool);
  filter.resume(before, {});
  filter.advance({clipped, tables, kUnseen},
                 test::uniform_flow(kRows, kCols, static_cast<float>(step.dx), static_cast<float>(step.dy)));
  const float aged =
      kVariance * (1 + options.variance_growth) + std::pow(options.relative_growth * kSeen, 2.f);
  int seen = 0, unseen = 0;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      // beside the edge of what is known its contrast counts, too
      const auto was_known = [&](int by_x, int by_y) {
        return known(std::clamp(x + step.dx + by_x, 0, kCols - 1),
                     std::clamp(y + step.dy + by_y, 0, kRows - 1));
      };
      const int corners = was_known(-2, -2) + was_known(2, -2) + was_known(-2, 2) + was_known(2, 2);
      if (corners % 4 != 0) continue;
      CAPTURE(step.dx, step.dy, x, y);
      const float radiance = filter.state().radiance.at(1, y, x),
                  variance = filter.state().variance.at(1, y, x);
      if (corners == 4) {
        REQUIRE(radiance == Approx(kSeen).epsilon(0.005));
        REQUIRE(variance == Approx(aged).epsilon(1e-3));
        ++seen;
      } else {
        REQUIRE(radiance == Approx(kBound).epsilon(0.005));
        REQUIRE(variance >= kUnseen);
        ++unseen;
      }
    }
  CHECK(seen > 100);
  CHECK(unseen > 100);
}

TEST_CASE("light that changes slowly is followed, though every frame agrees with what was known before") {
  constexpr int kRows = 20, kCols = 24;
  constexpr float kFirst = 0.2f, kPerFrame = 1.005f;
  WorkerPool pool(1);
  const NoiseModel noise{.full_well = 5555, .read_noise = 0, .code_noise = 0};  // 3 % of that light
  const ExposureTables tables(Response::gamma(2.2f), noise, 1);
  StateFilter filter({}, kRows, kCols, pool);
  ExposedFrame frame;
  frame.codes = Image<float>(3, kRows, kCols);
  float light = kFirst;
  for (; frame.index < 60; ++frame.index, light *= kPerFrame) {
    frame.codes.fill(tables.code(0, light));
    if (frame.index == 0) {
      filter.restart({frame, tables, kUnseen});
      continue;
    }
    filter.advance({frame, tables, kUnseen}, test::uniform_flow(kRows, kCols));
    // 1.1 % behind; 5 where light is expected to stay as it is
    CAPTURE(frame.index);
    for (const float l : filter.state().radiance.samples()) REQUIRE(l == Approx(light).epsilon(0.02));
  }
}

TEST_CASE("each channel has its own curve and its own noise") {
  constexpr int kRows = 20, kCols = 24;
  constexpr float kCode = 128;
  const std::array<float, 3> exponents{1.6f, 2.2f, 3};
  std::array<Response::Curve, 3> inverse{};
  for (std::size_t c = 0; c < 3; ++c) inverse[c] = Response::gamma(exponents[c]).inverse(0);
  const Response response(inverse);
  // of coarse codes, whose steps are of another size in each channel
  const NoiseModel coarse{.full_well = 1e6f, .read_noise = 0, .code_noise = 0, .code_step = 4};
  const ExposureTables first(response, coarse, 0.5f), second(response, coarse, 1);
  WorkerPool pool(1);
  const StateOptions options;
  StateFilter filter(options, kRows, kCols, pool);
  ExposedFrame frame;
  frame.exposure = 0.5f;
  frame.codes = Image<float>(3, kRows, kCols);
  frame.codes.fill(kCode);
  filter.restart({frame, first, kUnseen});
  std::array<float, 3> light{};
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    CAPTURE(c);
    light[channel] = 2 * inverse[channel][static_cast<std::size_t>(kCode)];
    const float noise = std::sqrt(first.variance(c, light[channel])),
                own = options.fusion.relative_noise * light[channel];
    CHECK(filter.state().radiance.at(c, 9, 11) == Approx(light[channel]).epsilon(1e-3));
    CHECK(filter.state().variance.at(c, 9, 11) == Approx(noise * noise + own * own).epsilon(1e-3));
  }
  frame.index = 1, frame.exposure = 1;
  for (int c = 0; c < 3; ++c)
    std::fill_n(frame.codes.plane(c), frame.codes.plane_size(),
                second.code(c, light[static_cast<std::size_t>(c)]));
  filter.advance({frame, second, kUnseen}, test::uniform_flow(kRows, kCols));
  for (int c = 0; c < 3; ++c) {
    CAPTURE(c);
    CHECK(filter.state().radiance.at(c, 9, 11) == Approx(light[static_cast<std::size_t>(c)]).epsilon(1e-3));
  }
}

TEST_CASE("what samples were off by is forgotten with the response, and with the scene") {
  constexpr int kRows = 20, kCols = 24;
  WorkerPool pool(1);
  const NoiseModel quiet{.full_well = 1e6f, .read_noise = 0, .code_noise = 0};
  const ExposureTables tables(Response::gamma(2.2f), quiet, 1);
  StateFilter filter({}, kRows, kCols, pool);
  ExposedFrame frame;
  frame.codes = Image<float>(3, kRows, kCols);
  const auto show = [&](float code) {
    frame.codes.fill(code);
    if (frame.index++ == 0)
      filter.restart({frame, tables, kUnseen});
    else
      filter.advance({frame, tables, kUnseen}, test::uniform_flow(kRows, kCols));
  };
  const auto excess = [&] {
    float most = 0;
    for (const auto& channel : filter.residuals().excess(1).bins)
      most = std::max(most, std::ranges::max(channel));
    return most;
  };
  show(128);
  CHECK(excess() == 0);
  show(132);
  CHECK(excess() > 0);
  filter.forget_residuals();
  CHECK(excess() == 0);
  show(128);
  CHECK(excess() > 0);
  filter.restart({frame, tables, kUnseen});
  CHECK(excess() == 0);
}

TEST_CASE("what is clipped in every frame stays the highest lower bound, and is called unseen") {
  test::MovingScene scene;
  scene.sensitivity = 1e7;
  scene.full_well = 0;
  scene.exposures_s = GENERATE(std::vector{0.001, 0.004, 0.016}, std::vector{0.016, 0.001, 0.004});
  WorkerPool pool(1);
  StateFilter filter({}, scene.rows, scene.cols, pool);
  float highest = 0;
  for (int i = 0; i < 6; ++i) {  // ends on a longer exposure, whose bound is lower than what is known
    const auto frame = exposed(scene.frame(i), i);
    const ExposureTables tables(Response::gamma(2.2f), {}, frame.exposure);
    if (i == 0)
      filter.restart({frame, tables, kUnseen});
    else
      filter.advance({frame, tables, kUnseen}, test::uniform_flow(scene.rows, scene.cols));
    highest = std::max(highest, 1 / frame.exposure);
    INFO("frame " << i);
    for (const float v : filter.state().variance.samples()) REQUIRE(v >= kUnseen);
    for (const float l : filter.state().radiance.samples()) REQUIRE(l == Approx(highest));
  }
  CHECK(highest == Approx(4));
}

TEST_CASE("what is clipped where it was dark is something else, though the place is surely the same") {
  constexpr int kRows = 20, kCols = 24;
  WorkerPool pool(1);
  const ExposureTables tables(Response::gamma(2.2f), {}, 1);
  ExposedFrame frame;
  frame.codes = Image<float>(3, kRows, kCols);
  frame.codes.fill(tables.code(0, 0.05f));
  StateFilter filter({}, kRows, kCols, pool);
  filter.restart({frame, tables, kUnseen});
  frame.index = 1, frame.codes.fill(kMaxCode);
  filter.advance({frame, tables, kUnseen}, test::uniform_flow(kRows, kCols));  // of no doubt
  for (const float l : filter.state().radiance.samples()) REQUIRE(l == 1);
  for (const float v : filter.state().variance.samples()) REQUIRE(v >= kUnseen);
}

TEST_CASE("what is clipped is called unseen by day after a night, too, and its bound rises with the light") {
  constexpr int kRows = 20, kCols = 24;
  constexpr float kNight = 1, kDay = 4e-6f;
  WorkerPool pool(1);
  StateFilter filter({}, kRows, kCols, pool);
  ExposedFrame frame;
  frame.codes = Image<float>(3, kRows, kCols);
  frame.codes.fill(kMaxCode);
  for (const float exposure : {kNight, kDay, kNight, kDay}) {
    const float unseen = unseen_variance_from(frame.index == 0 ? 1 / kNight : 1 / kDay);
    frame.exposure = exposure;
    const ExposureTables tables(Response::gamma(2.2f), {}, exposure);
    if (frame.index == 0)
      filter.restart({frame, tables, unseen});
    else
      filter.advance({frame, tables, unseen}, test::uniform_flow(kRows, kCols));
    INFO("frame " << frame.index);
    for (const float v : filter.state().variance.samples()) REQUIRE(v >= unseen);
    for (const float l : filter.state().radiance.samples())
      REQUIRE(l == Approx(frame.index == 0 ? 1 / kNight : 1 / kDay));
    ++frame.index;
  }
  // what the day shows replaces the bound, with the variance of a sample
  frame.exposure = kDay, frame.codes.fill(128);
  const ExposureTables tables(Response::gamma(2.2f), {}, kDay);
  filter.advance({frame, tables, unseen_variance_from(1 / kDay)}, test::uniform_flow(kRows, kCols));
  const float seen = tables.radiance(0, 128);
  for (const float l : filter.state().radiance.samples()) REQUIRE(l == Approx(seen).epsilon(0.01));
  for (const float v : filter.state().variance.samples()) REQUIRE(v < 0.01f * seen * seen);
}

TEST_CASE(
    "a nearly black frame whose motion nobody believes does not replace what was seen, nor does a later "
    "one") {
  constexpr int kRows = 20, kCols = 24;
  constexpr float kSeen = 1e-3f;
  WorkerPool pool(1);
  const auto shown = [&](int index, float exposure) {
    ExposedFrame frame;
    frame.index = index, frame.exposure = exposure;
    frame.codes = Image<float>(3, kRows, kCols);
    frame.codes.fill(std::round(ExposureTables(Response::gamma(2.2f), {}, exposure).code(0, kSeen)));
    return frame;
  };
  const ExposedFrame longest = shown(0, 64), black = shown(1, 1 / 16.f);
  const ExposureTables of_longest(Response::gamma(2.2f), {}, 64),
      of_black(Response::gamma(2.2f), {}, 1 / 16.f);
  REQUIRE(black.codes.at(0, 5, 5) < 6);
  REQUIRE(of_black.radiance(0, 6) > 4 * kSeen);
  FlowField nowhere = test::uniform_flow(kRows, kCols);
  nowhere.confidence.fill(0);
  StateFilter filter({}, kRows, kCols, pool);
  const float unseen = unseen_variance_from(16);
  filter.restart({longest, of_longest, unseen});
  filter.advance({black, of_black, unseen}, nowhere);
  for (const float l : filter.state().radiance.samples()) REQUIRE(l == Approx(kSeen).epsilon(0.5));

  // clipped, and of a place that no frame saw before
  RadianceState bound{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                      Image<float>(1, kRows, kCols)};
  bound.radiance.fill(1 / 64.f), bound.variance.fill(kUnseenVariance);
  Samples samples;
  Fusion& fusion = filter.fusion();
  fusion.sample(black.codes, black.codes, of_black, samples);
  RadianceState joined;
  Image<float> gate(1, kRows, kCols), share;
  gate.fill(1);
  fusion.update({bound, samples, of_black, unseen}, &gate, nullptr, joined, share);
  for (const float l : joined.radiance.samples()) REQUIRE(l > 0.7f / 64);
}

TEST_CASE("a state that is doubted is no worse than a guess, and weighs against a dark code") {
  constexpr int kRows = 20, kCols = 24;
  constexpr float kSeen = 1e-3f, kDarkCode = 4;
  WorkerPool pool(1);
  const NoiseModel quiet{.full_well = 1e6f, .read_noise = 1, .code_noise = 0.1f};
  const ExposureTables tables(Response::gamma(2.2f), quiet, 1 / 64.f);
  const float dark = tables.radiance(0, kDarkCode);
  REQUIRE(dark > 6 * kSeen);
  ExposedFrame frame;
  frame.index = 1, frame.exposure = 1 / 64.f;
  frame.codes = Image<float>(3, kRows, kCols);
  frame.codes.fill(kDarkCode);
  RadianceState seen{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                     Image<float>(1, kRows, kCols)};
  seen.radiance.fill(kSeen), seen.variance.fill(kSeen * kSeen);
  FlowField doubtful = test::uniform_flow(kRows, kCols);
  doubtful.confidence.fill(0.0021f);  // just not lost
  StateFilter filter({}, kRows, kCols, pool);
  filter.resume(seen, {});
  filter.advance({frame, tables, unseen_variance_from(64)}, doubtful);
  for (const float l : filter.state().radiance.samples()) REQUIRE(l < 0.7f * dark);
}

TEST_CASE(
    "what compression leaves below white in a clipped place does not darken it, a clean camera's code does") {
  constexpr int kRows = 20, kCols = 24, kY = 9, kX = 11;
  WorkerPool pool(1);
  const auto shown = [&](int index, float exposure, float code) {
    ExposedFrame frame;
    frame.index = index, frame.exposure = exposure;
    frame.codes = Image<float>(3, kRows, kCols);
    frame.codes.fill(code);
    return frame;
  };
  const auto seen_then_rung = [&](float code_noise, float code) {
    const NoiseModel noise{.full_well = 4000, .read_noise = 5, .code_noise = code_noise};
    const ExposureTables of_short(Response::gamma(2.2f), noise, 0.25f),
        of_long(Response::gamma(2.2f), noise, 4);
    const ExposedFrame first = shown(0, 0.25f, 200);
    ExposedFrame second = shown(1, 4, 255);
    for (int c = 0; c < 3; ++c) second.codes.at(c, kY, kX) = code;
    StateFilter filter({}, kRows, kCols, pool);
    filter.restart({first, of_short, kUnseen});
    filter.advance({second, of_long, kUnseen}, test::uniform_flow(kRows, kCols));
    return filter.state().radiance.at(1, kY, kX) / of_short.radiance(1, 200);
  };
  CHECK(seen_then_rung(1, 238) == Approx(1).epsilon(0.01));
  CHECK(seen_then_rung(0.1f, 238) < 0.5f);
  CHECK(seen_then_rung(1, 215) < 0.3f);  // no ringing reaches so far: something else is there now
}

TEST_CASE("a sample that contradicts the state is gated, one that agrees is not") {
  constexpr int kRows = 20, kCols = 20;
  WorkerPool pool(1);
  Fusion fusion({}, pool);
  RadianceState state{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                      Image<float>(1, kRows, kCols)};
  state.radiance.fill(0.2f);
  state.variance.fill(1e-5f);
  const ExposureTables tables(Response::gamma(2.2f), {}, 1);
  Image<float> codes(3, kRows, kCols), confidence(1, kRows, kCols), gate, contrast;
  confidence.fill(1);
  Samples samples;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x)
      for (int c = 0; c < 3; ++c) codes.at(c, y, x) = tables.code(c, x < kCols / 2 ? 0.2f : 0.5f);
  fusion.sample(codes, codes, tables, samples);
  fusion.gate({state, samples, tables, kUnseen}, confidence, gate, contrast);
  CHECK(gate.at(0, 10, 2) > 0.95f);
  CHECK(gate.at(0, 10, 17) < 0.05f);
  CHECK(gate.at(0, 10, 17) > 0);
}
