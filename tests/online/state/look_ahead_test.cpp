#include "online/state/look_ahead.h"

#include <utility>

#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a frame that shows a flash keeps it, though the next one shows the dark behind it") {
  constexpr int kRows = 20, kCols = 24;
  WorkerPool pool(1);
  const ExposureTables of_next(Response::gamma(2.2f), {}, 4);  // clips from .25 on
  RadianceState flash{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                      Image<float>(1, kRows, kCols)};
  const FlowField path = test::uniform_flow(kRows, kCols);
  const auto joined = [&](float bound, float next, bool shorter = false) {
    flash.radiance.fill(bound), flash.variance.fill(kUnseenVariance);
    ExposedFrame later;
    later.index = 1, later.exposure = 4;
    later.codes = Image<float>(3, kRows, kCols);
    later.codes.fill(of_next.code(1, next));
    const LaterFrame next_frame{&later, &path, &of_next, shorter};
    Fusion fusion({}, pool);
    JoinedState both;
    LookAhead(pool).join(flash, {&next_frame, 1}, unseen_variance_from(4), fusion, both);
    return both.radiance.at(1, 9, 11);
  };
  CHECK(joined(1, 0.1f) == 1);
  CHECK(joined(1, 0.18f) == Approx(0.18f).epsilon(0.05));   // nearly clipped: it may be the same surface
  CHECK(joined(0.2f, 0.1f) == Approx(0.1f).epsilon(0.05));  // a bound that the next frame's white is beyond
  CHECK(joined(1, 0.1f, true) == Approx(0.1f).epsilon(0.05));  // a longer frame's own bound is lower
}

TEST_CASE("a flash is kept beside two frames that show the dark behind it, and is still what nobody saw") {
  constexpr int kRows = 20, kCols = 24;
  constexpr float kBound = 1, kDark = 0.1f;
  WorkerPool pool(1);
  const ExposureTables of_later(Response::gamma(2.2f), {}, 4);  // clips from .25 on
  const FlowField path = test::uniform_flow(kRows, kCols);
  RadianceState flash{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                      Image<float>(1, kRows, kCols)};
  flash.radiance.fill(kBound), flash.variance.fill(kUnseenVariance);
  ExposedFrame next, after;
  next.index = 1, after.index = 2;
  for (ExposedFrame* frame : {&next, &after}) {
    frame->exposure = 4;
    frame->codes = Image<float>(3, kRows, kCols);
    frame->codes.fill(of_later.code(1, kDark));
  }
  const LaterFrame later[] = {{&next, &path, &of_later}, {&after, &path, &of_later}};
  for (const std::size_t frames : {1u, 2u}) {
    CAPTURE(frames);
    Fusion fusion({}, pool);
    JoinedState both;
    LookAhead(pool).join(flash, {later, frames}, unseen_variance_from(4), fusion, both);
    CHECK(both.radiance.at(1, 9, 11) == kBound);
    CHECK(both.variance.at(1, 9, 11) == kUnseenVariance);
    CHECK(both.later_share.at(0, 9, 11) == Approx(0).margin(1e-6));
  }
}

TEST_CASE("the share of later frames is how much more is known of a pixel with all of them than before") {
  constexpr int kRows = 20, kCols = 24;
  constexpr float kLight = 0.3f, kVariance = 9e-4f;  // known to a tenth
  WorkerPool pool(1);
  const FlowField still = test::uniform_flow(kRows, kCols);
  RadianceState known{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                      Image<float>(1, kRows, kCols)};
  known.radiance.fill(kLight), known.variance.fill(kVariance);
  const ExposureTables of_next(Response::gamma(2.2f), {}, 0.5f), of_after(Response::gamma(2.2f), {}, 1);
  ExposedFrame next, after;
  next.index = 1, next.exposure = 0.5f, after.index = 2, after.exposure = 1;
  for (const auto& [frame, tables] : {std::pair(&next, &of_next), std::pair(&after, &of_after)}) {
    frame->codes = Image<float>(3, kRows, kCols);
    frame->codes.fill(tables->code(1, kLight));
  }
  const LaterFrame later[] = {{&next, &still, &of_next, true}, {&after, &still, &of_after, false}};
  float before = 0;
  for (const std::size_t frames : {1u, 2u}) {
    Fusion fusion({}, pool);
    JoinedState joined;
    LookAhead(pool).join(known, {later, frames}, unseen_variance_from(4), fusion, joined);
    CAPTURE(frames);
    const float share = joined.later_share.at(0, 9, 11);
    CHECK(joined.radiance.at(1, 9, 11) == Approx(kLight).epsilon(0.005));
    CHECK(share == Approx(1 - joined.variance.at(1, 9, 11) / kVariance).margin(1e-4));
    CHECK(share > before + 0.01f);
    before = share;
  }
}

TEST_CASE("the second interval of a path is read where the first one leads, and trusted as it is there") {
  constexpr int kRows = 20, kCols = 64, kTurn = 32, kLost = 40;  // columns of the next frame
  constexpr float kClipped = 16;                                 // exposure of the next frame
  WorkerPool pool(1);
  RadianceState unseen{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                       Image<float>(1, kRows, kCols)};
  unseen.radiance.fill(0.01f), unseen.variance.fill(kUnseenVariance);
  const FlowField first = test::uniform_flow(kRows, kCols, 8);
  FlowField second = test::uniform_flow(kRows, kCols, 4);
  const ExposureTables of_next(Response::linear(), {}, kClipped), of_after(Response::linear(), {}, 1);
  ExposedFrame next, after;
  next.index = 1, next.exposure = kClipped, after.index = 2;
  next.codes = Image<float>(3, kRows, kCols), after.codes = Image<float>(3, kRows, kCols);
  next.codes.fill(kMaxCode);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      for (int c = 0; c < 3; ++c) after.codes.at(c, y, x) = static_cast<float>(40 + x);
      if (x >= kTurn) second.vectors.at(0, y, x) = -4;
      if (x >= kLost) second.confidence.at(0, y, x) = 0;
    }
  const LaterFrame later[] = {{&next, &first, &of_next}, {&after, &second, &of_after, true}};
  Fusion fusion({}, pool);
  JoinedState joined;
  LookAhead(pool).join(unseen, later, unseen_variance_from(4), fusion, joined);
  for (const int x : {4, 10, 20, 27, 30}) {
    const int leads_to = x + 8 + (x + 8 < kTurn ? 4 : -4);
    CAPTURE(x, leads_to);
    CHECK(joined.radiance.at(1, 9, x) == Approx(static_cast<float>(40 + leads_to) / 255).epsilon(0.01));
  }
  for (const int x : {34, 38}) CHECK(joined.radiance.at(1, 9, x) == Approx(1 / kClipped));  // of the next one
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
