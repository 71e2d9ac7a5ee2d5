#include "online/response/blur_between.h"

#include <algorithm>
#include <cmath>

#include "online/response/response_estimator.h"
#include "tests/support/coded_frame.h"
#include "tests/support/moving_scene.h"
#include "tests/support/response_error.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::response_error;

namespace {

constexpr int kRows = 192, kCols = 256;

// Light of a scene over eight stops, fine and coarse texture over slow changes.
double scene_at(int c, double x, int y) {
  const auto random = [&](double px, int py, int cell) {
    const auto at = [&](double cx, int cy) {
      return test::MovingScene::noise(
          static_cast<std::uint64_t>((c * 4099 + cy + 7) * 8209 + static_cast<int>(cx) + 97));
    };
    const double cx = std::floor(px / cell), part = px / cell - cx;
    return (1 - part) * at(cx, py / cell) + part * at(cx + 1, py / cell);
  };
  return std::exp2(-4 + 2 * std::sin(x * 0.021 + 0.3 * c) * std::cos(y * 0.027) + 0.6 * random(x, y, 3) +
                   0.5 * random(x, y, 14));
}

// Such a frame, of which each pixel is the mean of so many, along x or along y.
ExposedFrame recorded(float exposure, int blur, bool along_y, const Response& response, int index = 0) {
  ExposedFrame frame = test::coded_frame(kRows, kCols, [&](int c, int y, int x) {
    double sum = 0;
    for (int i = 0; i < blur; ++i) {
      const int by = i - blur / 2;
      sum += along_y ? scene_at(c, y + by, x) : scene_at(c, x + by, y);
    }
    const double light = std::min(1.0, static_cast<double>(exposure) * sum / blur);
    const double noise =
        0.004 * std::sqrt(light) *
        test::MovingScene::noise(static_cast<std::uint64_t>(((index * 3 + c) * kRows + y) * kCols + x + 1));
    const auto seen = static_cast<float>(std::clamp(light + noise, 0.0, 1.0));
    return std::round(response.code_of(c, seen));
  });
  frame.index = index, frame.exposure = exposure;
  return frame;
}

ExposedFrame sharp(float exposure, bool along_y = false) {
  return recorded(exposure, 1, along_y, Response::gamma(1.8f), 1);
}

}  // namespace

TEST_CASE("how much more a motion blurs the longer exposure is found, along the motion") {
  for (const int length : {3, 5, 9})
    for (const bool along_y : {false, true}) {
      const ExposedFrame longer = recorded(2, length, along_y, Response::gamma(1.8f));
      const BlurLengths found = blur_between(sharp(0.5f, along_y).codes, longer.codes);
      INFO(length << " pixels along " << (along_y ? "y: " : "x: ") << found.x << " x " << found.y);
      CHECK((along_y ? found.y : found.x) == Approx(length).epsilon(0.1));
      CHECK((along_y ? found.x : found.y) < 1.1f);
    }
}

TEST_CASE("frames of one sharpness, or of too little that both show, have no blur between them") {
  const Response response = Response::gamma(1.8f);
  CHECK_FALSE(blur_between(sharp(0.5f).codes, recorded(2, 1, false, response).codes).any());
  CHECK_FALSE(
      blur_between(recorded(0.5f, 5, false, response, 1).codes, recorded(2, 5, false, response).codes).any());
  CHECK_FALSE(
      blur_between(recorded(0.5f, 5, false, response, 1).codes, recorded(2, 1, false, response).codes).any());
  CHECK_FALSE(blur_between(sharp(0.002f).codes, recorded(2, 5, false, response).codes).any());
  CHECK_FALSE(blur_between(sharp(0.5f).codes, recorded(1000, 5, false, response).codes).any());
  Image<float> small(3, 12, 40);
  CHECK_FALSE(blur_between(small, small).any());
}

TEST_CASE("fine texture that only the shorter exposure has is no blur") {
  ExposedFrame shorter = sharp(0.5f);
  const ExposedFrame longer = recorded(2, 1, false, Response::gamma(1.8f));
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        float& code = shorter.codes.at(c, y, x);
        code = std::clamp(
            code + 8 * static_cast<float>(test::MovingScene::noise(static_cast<std::uint64_t>(x / 2 + 1000))),
            0.f, 255.f);
      }
  CHECK_FALSE(blur_between(shorter.codes, longer.codes).any());
}

TEST_CASE("where motion blurs a part of the scene alone there is no blur between the frames") {
  const Response camera = Response::gamma(1.8f);
  ExposedFrame longer = recorded(2, 1, false, camera);
  const ExposedFrame moving = recorded(2, 5, false, camera);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y) {
      const int from = kCols * 11 / 20;
      std::copy(moving.codes.row(c, y) + from, moving.codes.row(c, y) + kCols, longer.codes.row(c, y) + from);
    }
  CHECK_FALSE(blur_between(sharp(0.5f).codes, longer.codes).any());
}

TEST_CASE("a channel is blurred in light, and what lies beyond an edge is as the edge") {
  Image<float> codes(3, 8, 40), blurred;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 40; ++x) codes.at(1, y, x) = x < 20 ? 20.f : 200.f;
  blur_channel(codes, 1, {.x = 4, .y = 3}, blurred);
  CHECK(blurred.at(0, 0, 0) == Approx(20).margin(0.1));
  CHECK(blurred.at(0, 7, 39) == Approx(200).margin(0.1));
  const double dark = std::pow(20 / 255., 2.2), bright = std::pow(200 / 255., 2.2);
  // half of the box reaches across: of the pixel before the edge 1.5 pixels
  CHECK(blurred.at(0, 4, 19) == Approx(255 * std::pow((2.5 * dark + 1.5 * bright) / 4, 1 / 2.2)).margin(0.3));
}

TEST_CASE("a response is found as well from frames that motion blurs") {
  const Response camera = Response::gamma(1.8f);
  const auto error_of = [&](int blur) {
    ResponseEstimator estimator;
    ExposedFrame before;
    for (int i = 0; i < 6; ++i) {
      ExposedFrame frame = recorded(i % 2 == 0 ? 0.25f : 2, i % 2 == 0 ? 1 : blur, false, camera, i);
      if (i > 0) CHECK(estimator.add_pair(before, frame));
      std::swap(before, frame);
    }
    return response_error(estimator.estimate({}, ResponseModel::Curve).response, camera);
  };
  const double sharp = error_of(1), blurred = error_of(9);
  INFO("stops rms: sharp " << sharp << ", blurred " << blurred);
  CHECK(blurred < 1.3 * sharp + 0.01);
}
