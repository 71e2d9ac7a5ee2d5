#include <cmath>

#include "capture/to_exposed_frame.h"
#include "online/pictures/local_statistics.h"
#include "online/pictures/warp.h"
#include "online/state/look_ahead.h"
#include "online/state/state_filter.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

const float kUnseen = unseen_variance_from(4);

Image<float> texture(int rows, int cols) {
  Image<float> image(3, rows, cols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        image.at(c, y, x) = 2 + static_cast<float>(std::sin(0.31 * x + c) * std::cos(0.23 * y));
  return image;
}

Image<float> uniform_flow(int rows, int cols, float dx, float dy) {
  Image<float> flow(2, rows, cols);
  std::fill_n(flow.plane(0), flow.plane_size(), dx);
  std::fill_n(flow.plane(1), flow.plane_size(), dy);
  return flow;
}

FlowField still(int rows, int cols) {
  FlowField flow{uniform_flow(rows, cols, 0, 0), Image<float>(1, rows, cols)};
  flow.confidence.fill(1);
  return flow;
}

ExposedFrame unpacked(const RawFrame& raw, int index) {
  ExposedFrameSettings settings;
  settings.reference_exposure = 0.004;
  return to_exposed_frame(raw, index, 1 / 30., settings).value();
}

}  // namespace

TEST_CASE("a picture that does not move is copied bit for bit") {
  WorkerPool pool(2);
  const auto image = texture(21, 34);
  Image<float> out;
  for (const float tiny : {0.f, 0.01f, -0.015f}) {  // below half of 1/32 pixel
    warp_radiance(image, uniform_flow(21, 34, tiny, -tiny), out, pool);
    REQUIRE(std::equal(image.samples().begin(), image.samples().end(), out.samples().begin()));
  }
}

TEST_CASE("a warp by whole and by fractional pixels finds the values of a smooth picture") {
  WorkerPool pool(1);
  const auto image = texture(40, 60);
  Image<float> cubic, radiance, linear;
  for (const float dx : {3.f, -2.f, 0.5f, 1.34375f}) {
    warp_cubic(image, uniform_flow(40, 60, dx, 1), cubic, pool);
    warp_radiance(image, uniform_flow(40, 60, dx, 1), radiance, pool);
    warp_linear(image, uniform_flow(40, 60, dx, 1), linear, pool);
    for (int y = 6; y < 34; ++y)
      for (int x = 6; x < 54; ++x) {
        const double truth =
            2 + std::sin(0.31 * (x + static_cast<double>(dx)) + 1) * std::cos(0.23 * (y + 1));
        REQUIRE(cubic.at(1, y, x) == Approx(truth).margin(0.004));
        REQUIRE(radiance.at(1, y, x) == Approx(truth).margin(0.008));
        REQUIRE(linear.at(1, y, x) == Approx(truth).margin(0.02));
      }
  }
}

TEST_CASE("radiance between a dark place and a bright one rings on neither side") {
  WorkerPool pool(1);
  Image<float> edge(1, 6, 16), out;
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 16; ++x) edge.at(0, y, x) = x < 8 ? 0.01f : 50;
  for (int times = 0; times < 8; ++times) {  // as a state that is carried on and on
    warp_radiance(edge, uniform_flow(6, 16, times % 2 == 0 ? 0.5f : -0.5f, 0), out, pool);
    std::swap(edge, out);
  }
  CHECK(edge.at(0, 3, 2) == Approx(0.01f).epsilon(0.02));
  CHECK(edge.at(0, 3, 13) == Approx(50).epsilon(0.02));
  for (const float v : edge.samples()) CHECK((v > 0.005f && v < 100));
}

TEST_CASE("a flow that leads nowhere repeats the border and reads nothing outside") {
  WorkerPool pool(1);
  const auto image = texture(5, 7);
  Image<float> out;
  for (const float wild :
       {1e9f, -1e9f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    warp_radiance(image, uniform_flow(5, 7, wild, wild), out, pool);
    for (const float v : out.samples()) REQUIRE(std::isfinite(v));
    warp_linear(image, uniform_flow(5, 7, wild, wild), out, pool);
    for (const float v : out.samples()) REQUIRE((v >= 1 && v <= 3));
  }
}

TEST_CASE("box means and local contrast agree with sums written out", "[isa]") {
  WorkerPool pool(2);
  const auto image = texture(9, 11);
  Image<float> mean, contrast, small, large;
  box_mean(image, 1, small, pool);
  box_mean(image, 2, large, pool);
  local_contrast(image, mean, contrast, pool);
  const auto mirrored = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 11; ++x) {
      double sum[3] = {}, square = 0;
      for (int r = 1; r <= 2; ++r)
        for (int dy = -r; dy <= r; ++dy)
          for (int dx = -r; dx <= r; ++dx) {
            const auto v = static_cast<double>(image.at(2, mirrored(y + dy, 9), mirrored(x + dx, 11)));
            sum[r] += v;
            if (r == 1) square += v * v;
          }
      REQUIRE(small.at(2, y, x) == Approx(sum[1] / 9));
      REQUIRE(large.at(2, y, x) == Approx(sum[2] / 25));
      REQUIRE(mean.at(2, y, x) == Approx(sum[1] / 9));
      REQUIRE(contrast.at(2, y, x) == Approx(square / 9 - sum[1] / 9 * sum[1] / 9).margin(1e-5));
    }
}

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
    const auto frame = unpacked(scene.frame(i), i);
    const ExposureTables tables(response, noise, frame.exposure);
    if (i == 0)
      filter.restart({frame, tables, kUnseen});
    else
      filter.advance({frame, tables, kUnseen}, still(scene.rows, scene.cols));
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

TEST_CASE("what is clipped in every frame stays the highest lower bound, and is called unseen") {
  test::MovingScene scene;
  scene.sensitivity = 1e7;
  scene.full_well = 0;
  scene.exposures_s = GENERATE(std::vector{0.001, 0.004, 0.016}, std::vector{0.016, 0.001, 0.004});
  WorkerPool pool(1);
  StateFilter filter({}, scene.rows, scene.cols, pool);
  float highest = 0;
  for (int i = 0; i < 6; ++i) {  // ends on a longer exposure, whose bound is lower than what is known
    const auto frame = unpacked(scene.frame(i), i);
    const ExposureTables tables(Response::gamma(2.2f), {}, frame.exposure);
    if (i == 0)
      filter.restart({frame, tables, kUnseen});
    else
      filter.advance({frame, tables, kUnseen}, still(scene.rows, scene.cols));
    highest = std::max(highest, 1 / frame.exposure);
    INFO("frame " << i);
    for (const float v : filter.state().variance.samples()) REQUIRE(v >= kUnseen);
    for (const float l : filter.state().radiance.samples()) REQUIRE(l == Approx(highest));
  }
  CHECK(highest == Approx(4));
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
      filter.advance({frame, tables, unseen}, still(kRows, kCols));
    INFO("frame " << frame.index);
    for (const float v : filter.state().variance.samples()) REQUIRE(v >= unseen);
    for (const float l : filter.state().radiance.samples())
      REQUIRE(l == Approx(frame.index == 0 ? 1 / kNight : 1 / kDay));
    ++frame.index;
  }
  // what the day shows replaces the bound, with the variance of a sample
  frame.exposure = kDay, frame.codes.fill(128);
  const ExposureTables tables(Response::gamma(2.2f), {}, kDay);
  filter.advance({frame, tables, unseen_variance_from(1 / kDay)}, still(kRows, kCols));
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
  FlowField nowhere = still(kRows, kCols);
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
  FlowField doubtful = still(kRows, kCols);
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
    filter.advance({second, of_long, kUnseen}, still(kRows, kCols));
    return filter.state().radiance.at(1, kY, kX) / of_short.radiance(1, 200);
  };
  CHECK(seen_then_rung(1, 238) == Approx(1).epsilon(0.01));
  CHECK(seen_then_rung(0.1f, 238) < 0.5f);
  CHECK(seen_then_rung(1, 215) < 0.3f);  // no ringing reaches so far: something else is there now
}

TEST_CASE("a frame that shows a flash keeps it, though the next one shows the dark behind it") {
  constexpr int kRows = 20, kCols = 24;
  WorkerPool pool(1);
  const ExposureTables of_next(Response::gamma(2.2f), {}, 4);  // clips from .25 on
  RadianceState flash{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                      Image<float>(1, kRows, kCols)};
  const FlowField path = still(kRows, kCols);
  const auto joined = [&](float bound, float next, bool shorter = false) {
    flash.radiance.fill(bound), flash.variance.fill(kUnseenVariance);
    ExposedFrame later;
    later.index = 1, later.exposure = 4;
    later.codes = Image<float>(3, kRows, kCols);
    later.codes.fill(of_next.code(1, next));
    const LaterFrame next_frame{&later, &path, &of_next, shorter};
    Fusion fusion({}, pool);
    JoinedState both;
    LookAhead(pool).join(flash, {&next_frame, 1}, kUnseen, fusion, both);
    return both.radiance.at(1, 9, 11);
  };
  CHECK(joined(1, 0.1f) == 1);
  CHECK(joined(1, 0.18f) == Approx(0.18f).epsilon(0.05));   // nearly clipped: it may be the same surface
  CHECK(joined(0.2f, 0.1f) == Approx(0.1f).epsilon(0.05));  // a bound that the next frame's white is beyond
  CHECK(joined(1, 0.1f, true) == Approx(0.1f).epsilon(0.05));  // a longer frame's own bound is lower
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

TEST_CASE("the blur of a later frame is a part of the path to it, also where a frame between was lost") {
  ExposedFrame next, after;
  next.interval_s = after.interval_s = 1 / 30., next.blur_fraction = 0.4f, after.blur_fraction = 0.8f;
  const LaterFrame path[] = {{&next, nullptr, nullptr}, {&after, nullptr, nullptr}};
  CHECK(blur_of_path({path, 1}) == 0.4f);
  CHECK(blur_of_path({path, 2}) == 0.4f);  // half of both intervals
  next.interval_s = 2 / 30.;
  CHECK(blur_of_path({path, 1}) == 0.4f);
  CHECK(blur_of_path({path, 2}) == Approx(0.8 / 3));
  next.interval_s = after.interval_s = 0;  // times are unknown
  CHECK(blur_of_path({path, 2}) == 0.4f);
}
