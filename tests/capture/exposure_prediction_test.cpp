// Predictions from a history of controls by hand. How pictures shift them is tested with the whole matcher
// (frame_matcher_test.cpp).
#include "capture/exposure_prediction.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

// The controls of request and frame `i`: i + 1 ms, gain i + 1.
ControlHistory history_of(int frames, int late = -1) {
  ControlHistory history;
  for (int i = 0; i < frames; ++i) {
    const auto cookie = static_cast<std::uint64_t>(i);
    history.sent({cookie, (i + 1) * 1ms, i + 1.0}, i % 3);
    (void)history.completed(cookie, cookie, i == late);
  }
  return history;
}

TEST_CASE("time and gain are predicted from the requests as many frames before as each takes to act",
          "[capture]") {
  const ControlHistory history = history_of(8);
  for (int exposure = 0; exposure <= 3; ++exposure)
    for (int gain = 0; gain <= 3; ++gain) {
      const ExposurePrediction prediction(ControlDelays{exposure, gain});
      const auto claim = prediction.predict(history);
      REQUIRE(claim);
      CHECK(claim->exposure == Exposure{(8 - exposure) * 1ms, 8.0 - gain});
      CHECK(claim->source == ExposureSource::Predicted);
      CHECK_FALSE(prediction.doubtful(history));
      CHECK(prediction.shown(history)->slot == (7 - std::max(exposure, gain)) % 3);
    }
}

TEST_CASE("without delays, or before the first request acts, nothing is predicted", "[capture]") {
  CHECK_FALSE(ExposurePrediction(std::nullopt).predict(history_of(8)));
  CHECK_FALSE(ExposurePrediction(std::nullopt).doubtful(history_of(8, 7)));
  CHECK_FALSE(ExposurePrediction(ControlDelays{2, 1}).predict(history_of(2)));
  CHECK(ExposurePrediction(ControlDelays{2, 1}).predict(history_of(3)));
}

TEST_CASE("a prediction is doubtful where either of its controls was written late", "[capture]") {
  const ExposurePrediction prediction(ControlDelays{2, 1});
  for (int late = 0; late < 8; ++late)
    CHECK(prediction.doubtful(history_of(8, late)) == (late == 5 || late == 6));
}

TEST_CASE("however many requests in a row were not written, their exposure is doubtful", "[capture]") {
  // All from request `changed` on ask for the same; those from `late` on were written late or never.
  const auto doubtful = [](int changed, int late, int frames) {
    ControlHistory history;
    for (int i = 0; i < frames; ++i) {
      const auto cookie = static_cast<std::uint64_t>(i);
      history.sent({cookie, i < changed ? 1ms : 5ms, 1}, 0);
      (void)history.completed(cookie, cookie, i >= late);
    }
    return ExposurePrediction(ControlDelays{}).doubtful(history);
  };
  for (const int frames : {4, 9, 30, 60}) {
    CAPTURE(frames);
    CHECK(doubtful(0, 0, frames));
    CHECK(doubtful(3, 3, frames));
  }
  CHECK_FALSE(doubtful(3, 4, 9));
  CHECK_FALSE(doubtful(0, 1, 30));
}

TEST_CASE("what pictures told so long ago that its controls are forgotten shifts no prediction",
          "[capture]") {
  constexpr int kDelay = 3;
  const auto exposure_of = [](int request) { return Exposure{(1 << request % 3) * 1ms, 1}; };
  ControlHistory history;
  ExposurePrediction prediction(ControlDelays{kDelay, kDelay});
  for (int i = 0; i < 60; ++i) {
    const auto cookie = static_cast<std::uint64_t>(i);
    history.sent({cookie, exposure_of(i).time, 1}, i % 3);
    (void)history.completed(cookie, cookie, false);
    if (i == 10 || i == 11 || i == 41) prediction.learn(history, log_product(exposure_of(i - kDelay)));
  }
  CHECK(prediction.shift() == 0);
  CHECK(prediction.relocks() == 0);
}

}  // namespace
}  // namespace hdrcam
