#include "online/response/response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "online/response/curve_prior.h"
#include "online/response/histogram_matches.h"
#include "online/response/match_evidence.h"
#include "online/response/response_estimator.h"
#include "online/response/response_learner.h"
#include "tests/support/coded_frame.h"
#include "tests/support/moving_scene.h"
#include "tests/support/refused_threads.h"
#include "tests/support/response_error.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::response_error;

namespace {

std::vector<ExposedFrame> exposed(const test::MovingScene& scene, int count) {
  std::vector<ExposedFrame> frames;
  for (int i = 0; i < count; ++i) frames.push_back(test::exposed(scene.frame(i), i));
  return frames;
}

ResponseEstimate estimated(const std::vector<ExposedFrame>& frames,
                           ResponseModel model = ResponseModel::Curve) {
  ResponseEstimator estimator;
  for (std::size_t i = 1; i < frames.size(); ++i) CHECK(estimator.add_pair(frames[i - 1], frames[i]));
  return estimator.estimate({}, model);
}

// A frame of 256x192 whose codes are code(c, y, x).
template <class Code>
ExposedFrame frame_of(float exposure, Code&& code) {
  ExposedFrame frame = test::coded_frame(192, 256, code);
  frame.exposure = exposure;
  return frame;
}

// Black up to a sixtieth of full light.
Response long_toe() {
  Response::Curve inverse;
  for (std::size_t z = 0; z < inverse.size(); ++z)
    inverse[z] = std::pow(60.f, std::sqrt(static_cast<float>(z) / 255) - 1);
  return Response({inverse, inverse, inverse});
}

// A frame of fourteen stops from left to right.
ExposedFrame dark_to_bright(const Response& response, float exposure) {
  return frame_of(exposure, [&](int c, int, int x) {
    const float x_seen = exposure * std::exp2(-14 + 14 * static_cast<float>(x) / 256);
    return x_seen < response.inverse(c)[0] ? 0.f : std::round(response.code_of(c, std::min(1.f, x_seen)));
  });
}

// Codes of a pattern that is like no moving scene: mean +- contrast.
Image<float> another_scene(int rows, int cols, float mean, float contrast) {
  return test::coded_frame(rows, cols,
                           [&](int, int y, int x) {
                             return mean +
                                    contrast * static_cast<float>(std::sin(y * 0.7) * std::sin(x * 0.45 + 1));
                           })
      .codes;
}

}  // namespace

TEST_CASE("a channel whose white is smeared makes no light coloured") {
  // The same light and the same curve in all channels; blocks of blue are brighter or darker, as coarse steps
  // of colour make them.
  const bool is_smeared = GENERATE(true, false);
  CAPTURE(is_smeared);
  const Response response = Response::gamma(2.2f);
  const auto of_block = [](int y, int x, int size, int key) {
    return static_cast<float>(
        test::MovingScene::noise(static_cast<std::uint64_t>(((key * 1000) + y / size) * 1000 + x / size)));
  };
  std::vector<ExposedFrame> frames;
  for (int i = 0; i < 6; ++i) {
    const float exposure = i % 2 == 0 ? 2 : 32;
    frames.push_back(frame_of(exposure, [&](int c, int y, int x) {
      const float light = std::exp2(-7 + 2.2f * of_block(y, x, 12, 1));
      const float code = response.code_of(c, std::min(1.f, exposure * light));
      const float step = is_smeared && c == 2 ? 8 * of_block(y, x, 8, 2 + i) : 0;
      return std::round(std::clamp(code + step, 0.f, 255.f));
    }));
  }
  const ResponseEstimate found = estimated(frames);
  const auto middle = [&](int c) { return static_cast<double>(found.response.exposure_of(c, 127)); };
  CHECK(found.neutral_gains.has_value() == is_smeared);
  const double coloured = std::log2(middle(1) / middle(2));
  if (!found.neutral_gains) {
    CHECK(std::abs(coloured) < 0.02);
    return;
  }
  const ChannelGains& gains = *found.neutral_gains;
  CHECK(coloured > 0.3);
  CHECK(std::abs(coloured - std::log2(gains[2] / gains[1])) < 0.5 * coloured);
  CHECK(gains[0] == Approx(gains[1]).epsilon(0.02));
  CHECK(gains[0] * gains[1] * gains[2] == Approx(1));
}

TEST_CASE("a response is strictly monotone and inverts itself") {
  struct Row {
    float exponent, within;  // codes; an exponent of 4 has dark codes closer than the forward table: .18
  };
  for (const auto& [exponent, within] : {Row{1, 2e-3f}, {2.2f, 0.03f}, {4, 0.3f}}) {
    const Response response = Response::gamma(exponent);
    CAPTURE(exponent);
    for (int c = 0; c < 3; ++c) {
      CHECK(response.exposure_of(c, 255) == Approx(1));
      for (std::size_t z = 1; z < 256; ++z) REQUIRE(response.inverse(c)[z] > response.inverse(c)[z - 1]);
      for (float code = 3; code < 255; code += 3.5f)
        CHECK(response.code_of(c, response.exposure_of(c, code)) == Approx(code).epsilon(0).margin(within));
    }
  }
}

TEST_CASE("a stated response that is below 0 near black is above it") {
  Response::Curve stated;
  for (std::size_t z = 0; z < stated.size(); ++z) stated[z] = (static_cast<float>(z) - 12) / 243;
  const Response response({stated, stated, stated});
  CHECK(response.inverse(1)[0] >= 0);
  for (std::size_t z = 1; z < stated.size(); ++z) {
    REQUIRE(response.inverse(1)[z] > response.inverse(1)[z - 1]);
    REQUIRE(std::isfinite(std::log(response.inverse(1)[z])));
  }
  CHECK(response.exposure_of(1, 133.5f) == Approx(0.5));
}

TEST_CASE("the response is found from six frames of an unknown camera") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  struct Row {
    float gamma;
    double stops;  // the further from usual cameras, the more of the darkest codes the prior decides
  };
  for (const auto& [gamma, stops] : {Row{1.6f, 0.02}, {2.2f, 0.09}, {2.5f, 0.14}}) {
    scene.gamma = gamma;
    const auto estimate = estimated(exposed(scene, 6));
    const Response truth = Response::gamma(gamma);
    INFO("gamma " << gamma);
    CHECK(response_error(estimate.response, truth) < stops);
    CHECK(response_error(prior_mean_response(), truth) > 5 * response_error(estimate.response, truth));
    for (std::size_t c = 0; c < 3; ++c) CHECK(estimate.black_level[c] < 2);
  }
}

TEST_CASE("each channel has the curve that its own codes show") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  constexpr std::array<float, 3> kGammas{1.6f, 1.9f, 2.2f};
  std::vector<ExposedFrame> frames = exposed(scene, 6);
  std::array<Response::Curve, 3> inverse{};
  for (std::size_t c = 0; c < 3; ++c) {
    scene.gamma = kGammas[c];
    inverse[c] = Response::gamma(scene.gamma).inverse(0);
    const std::vector<ExposedFrame> of_channel = exposed(scene, 6);
    for (std::size_t i = 0; i < frames.size(); ++i)
      std::ranges::copy_n(of_channel[i].codes.plane(static_cast<int>(c)),
                          static_cast<std::ptrdiff_t>(frames[i].codes.plane_size()),
                          frames[i].codes.plane(static_cast<int>(c)));
  }
  const Response found = estimated(frames).response;
  const double error = response_error(found, Response(inverse));
  INFO(error << " stop rms of all channels");
  for (std::size_t turn = 1; turn < 3; ++turn) {  // the channels in another order
    std::rotate(inverse.begin(), inverse.begin() + 1, inverse.end());
    CHECK(response_error(found, Response(inverse)) > 2 * error);
  }
  CHECK(error < 0.1);
}

TEST_CASE("the models of a response that are there for comparison are what they are called") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  const auto frames = exposed(scene, 6);
  const auto is = [](const Response& a, const Response& b) { return a.inverse(1) == b.inverse(1); };
  CHECK(is(estimated(frames, ResponseModel::Linear).response, Response::linear()));
  CHECK(is(estimated(frames, ResponseModel::Mean).response, prior_mean_response()));
  struct Row {
    float gamma;
    double stops;
  };
  for (const auto& [gamma, stops] : {Row{1.6f, 0.04}, {2.2f, 0.12}, {2.5f, 0.2}}) {
    scene.gamma = gamma;
    const Response found = estimated(exposed(scene, 6), ResponseModel::Network).response;
    INFO("gamma " << gamma);
    CHECK(response_error(found, Response::gamma(gamma)) < stops);
    for (std::size_t z = 1; z < 256; ++z) REQUIRE(found.inverse(1)[z] > found.inverse(1)[z - 1]);
    CHECK(found.uncertainty(1, 60) == 0);  // which only the curve has
  }
  // an exposure ratio that the frames do not show: the network ignores no frame
  scene.gamma = 2.2f;
  auto wrong = exposed(scene, 6);
  for (ExposedFrame& frame : wrong) frame.exposure = std::sqrt(frame.exposure);
  CHECK(response_error(estimated(wrong, ResponseModel::Network).response, Response::gamma(2.2f)) > 0.5);
}

TEST_CASE("exposures of which pictures tell how far they are off are listed as they were stated") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  scene.exposures_s = {0.00101, 0.00403, 0.0162};
  const auto frames = exposed(scene, 6);
  const auto learned = estimated(frames).exposures.learned();
  REQUIRE(learned.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) CHECK(learned[i].stated == frames[i].exposure);
}

TEST_CASE("an exposure that is not the stated one is found with the response") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  const auto truth = exposed(scene, 6);
  const auto with_middle_off_by = [&](double stops) {
    auto frames = exposed(scene, 6);
    for (std::size_t i = 1; i < frames.size(); i += 3)
      frames[i].exposure *= std::exp2(static_cast<float>(stops));
    return estimated(frames);
  };
  // what the middle exposure is off against the other two; a common factor is not observable
  const auto off = [&](const ResponseEstimate& estimate, double stated_off) {
    const auto log2_of = [&](std::size_t i, double by) {
      const float stated = truth[i].exposure * std::exp2(static_cast<float>(by));
      return static_cast<double>(std::log2(estimate.exposures.corrected(stated) / truth[i].exposure));
    };
    return log2_of(1, stated_off) - (log2_of(0, 0) + log2_of(2, 0)) / 2;
  };
  for (const double stated_off : {-0.12, 0.0, 0.12}) {
    const ResponseEstimate estimate = with_middle_off_by(stated_off);
    INFO("stated " << stated_off << " stop off");
    CHECK(off(estimate, stated_off) == Approx(0).margin(0.01));
    CHECK(response_error(estimate.response, Response::gamma(2.2f)) < 0.09);
  }
  // of two exposures alone no ratio is known better than as it is stated
  scene.exposures_s = {0.001, 0.004};
  const auto two = exposed(scene, 6);
  CHECK(estimated(two).exposures.corrected(two[1].exposure) == Approx(two[1].exposure).epsilon(1e-3));
}

TEST_CASE("an exposure that is far from the stated one is no sign of a black level") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  for (const float stops : {-0.4f, -0.3f, 0.3f, 0.4f}) {
    CAPTURE(stops);
    auto frames = exposed(scene, 6);
    for (std::size_t i = 1; i < frames.size(); i += 3) frames[i].exposure *= std::exp2(stops);
    const ResponseEstimate estimate = estimated(frames);
    for (std::size_t c = 0; c < 3; ++c) CHECK(estimate.black_level[c] == 0);
  }
}

TEST_CASE("under a known response exposures are found as they are, and the noise with them") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  const Response known = Response::gamma(scene.gamma);
  for (const double true_stops : {0.0, 0.12, -0.3}) {
    auto frames = exposed(scene, 6);
    for (std::size_t i = 2; i < frames.size(); i += 3)
      frames[i].exposure *= static_cast<float>(std::exp2(-true_stops));
    ResponseEstimator estimator;
    for (std::size_t i = 1; i < frames.size(); ++i) CHECK(estimator.add_pair(frames[i - 1], frames[i]));
    const ResponseEstimate found = estimator.estimate_under(known, {});
    CHECK(response_error(found.response, known) == 0);
    const auto off = [&](std::size_t i) {
      return std::log2(
          static_cast<double>(found.exposures.corrected(frames[i].exposure) / frames[i].exposure));
    };
    INFO(true_stops << " stop: " << off(0) << " " << off(1) << " " << off(2));
    CHECK(off(1) - off(0) == Approx(0).margin(0.02));  // even where all would be a power
    CHECK(off(2) - off(1) == Approx(true_stops).margin(0.02));
  }
}

TEST_CASE(
    "under a known response noise in the dark is not taken for light that exposures would have to explain") {
  // ten bits, 20000 electrons, read noise 6; light of 1.5 codes in the short, of 6 in the long exposure
  constexpr double kFullWell = 20000, kReadNoise = 6, kLargest = 1023;
  const Response known = Response::gamma(2);
  ResponseEstimator estimator;
  std::array<ExposedFrame, 6> frames;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double light = (i % 2 == 0 ? 1.5 : 6) / kLargest;
    std::uint64_t pixel = i << 32;
    frames[i] = frame_of(i % 2 == 0 ? 1 : 4, [&](int, int, int) {
      const double electrons = light * kFullWell + test::MovingScene::noise(++pixel) *
                                                       std::hypot(std::sqrt(light * kFullWell), kReadNoise);
      const double code = std::round(std::clamp(electrons / kFullWell * kLargest, 0.0, kLargest));
      return static_cast<float>(255 * std::sqrt(code / kLargest));
    });
    if (i > 0) CHECK(estimator.add_pair(frames[i - 1], frames[i]));
  }
  const ExposureCorrections found = estimator.estimate_under(known, {}).exposures;
  const auto off = [&](std::size_t i) {
    return std::log2(found.corrected(frames[i].exposure) / frames[i].exposure);
  };
  INFO(off(0) << " " << off(1) << " stop");
  CHECK(off(1) - off(0) == Approx(0).margin(0.01));
}

TEST_CASE("under a known response two scenes on either side of a cut say nothing of their exposures") {
  const test::MovingScene scene;
  const Response known = Response::gamma(scene.gamma);
  auto frames = exposed(scene, 2);
  frames[1].codes = another_scene(scene.rows, scene.cols, 220, 20);
  REQUIRE_FALSE(ResponseEstimator().add_pair(frames[0], frames[1]));
  ResponseLearner learner({.known = known});
  const std::array<CompactFrame, 2> seen = {CompactFrame(frames[0], 8), CompactFrame(frames[1], 8)};
  learner.see_first(frames[0], nullptr);
  learner.see_first(frames[1], &seen[0]);
  WorkerPool pool(1);
  const ResponseEstimate found = learner.first(seen, {}, pool);
  for (const ExposedFrame& frame : frames) CHECK(found.exposures.corrected(frame.exposure) == frame.exposure);
}

TEST_CASE("what an exposure is off counts for all frames of it, however its reported times jitter") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  auto frames = exposed(scene, 6);
  for (std::size_t i = 1; i < frames.size(); i += 3) frames[i].exposure *= std::exp2(0.12f);
  const ExposureCorrections found = estimated(frames).exposures;
  const auto stops_off = [&](float exposure) { return std::log2(found.corrected(exposure) / exposure); };
  const float middle = frames[1].exposure;
  REQUIRE(stops_off(middle) < -0.04f);
  for (const float jitter : {-0.04f, -0.02f, 0.02f, 0.04f}) {
    INFO("jitter of " << jitter << " stop");
    CHECK(stops_off(middle * std::exp2(jitter)) == Approx(stops_off(middle)).epsilon(1e-3));
  }
}

TEST_CASE("what a longer exposure does not make brighter is black, even where the shorter one is all black") {
  constexpr float kPedestal = 16;
  const auto lamp = frame_of(32, [](int, int y, int x) {
    return kPedestal +
           std::max(0.f, 24 - std::hypot(static_cast<float>(x) - 128, static_cast<float>(y) - 96));
  });
  ResponseEstimator estimator;
  REQUIRE(estimator.add_pair(frame_of(1, [](int, int, int) { return kPedestal; }), lamp, SceneCuts::None));
  const ResponseEstimate found = estimator.estimate({});
  for (std::size_t c = 0; c < 3; ++c) CHECK(found.black_level[c] == Approx(kPedestal).margin(1));
}

TEST_CASE("what is a code in a shorter exposure and all light in a longer one is black") {
  // A camera with a toe, whose shorter exposure is hardly above its pedestal: the one code that it tells
  // apart is what a camera without a pedestal would show, too.
  constexpr float kPedestal = 9, kToe = 0.006f;
  const auto frame = [](float exposure) {
    return frame_of(exposure, [&](int, int, int x) {
      const float seen = exposure * std::exp2(-16 + 9.25f * static_cast<float>(x) / 256);
      return std::round(kPedestal + (255 - kPedestal) * std::max(0.f, seen - kToe));
    });
  };
  ResponseEstimator estimator;
  REQUIRE(estimator.add_pair(frame(1), frame(64), SceneCuts::None));
  const ResponseEstimate found = estimator.estimate({});
  for (std::size_t c = 0; c < 3; ++c) CHECK(found.black_level[c] == Approx(kPedestal).margin(1.5));
}

TEST_CASE(
    "two exposures that share no code still tell a long toe: what is white in one is hardly black in the "
    "other") {
  const Response response = long_toe();
  ResponseEstimator estimator;
  REQUIRE(estimator.add_pair(dark_to_bright(response, 1), dark_to_bright(response, 64), SceneCuts::None));
  const Response found = estimator.estimate({}).response;
  const auto stops_off = [&](const Response& of, float code) {
    return std::log2(of.exposure_of(1, code) / response.exposure_of(1, code));
  };
  for (const float code : {2.f, 4.f, 8.f}) {
    CAPTURE(code, stops_off(found, code), stops_off(prior_mean_response(), code));
    CHECK(std::abs(stops_off(found, code)) < 0.5f * std::abs(stops_off(prior_mean_response(), code)));
  }
}

TEST_CASE("under a known response what is white in one exposure and dark in the other moves no exposure") {
  const auto lamp = [](float exposure, float code) {  // beside nothing
    return frame_of(exposure, [&](int, int, int x) { return x < 128 ? 0.f : code; });
  };
  const std::array<ExposedFrame, 2> frames{lamp(1, 20), lamp(64, 255)};
  ResponseEstimator estimator;
  REQUIRE(estimator.add_pair(frames[0], frames[1], SceneCuts::None));
  const ExposureCorrections found = estimator.estimate_under(Response::gamma(2.2f), {}).exposures;
  for (const ExposedFrame& frame : frames)
    CHECK(found.corrected(frame.exposure) == Approx(frame.exposure).epsilon(1e-3));
}

TEST_CASE("a bound of white leaves open how far beyond it a toe is, however many frames show the bound") {
  const auto uncertainty_of_toe = [](int pairs) {  // ln x
    ResponseEstimator estimator;
    const Response response = long_toe();
    for (int i = 0; i < pairs; ++i)
      REQUIRE(estimator.add_pair(dark_to_bright(response, 1), dark_to_bright(response, 64), SceneCuts::None));
    return estimator.estimate({}).response.uncertainty(1, 4);
  };
  const float of_one = uncertainty_of_toe(1);
  CAPTURE(of_one, uncertainty_of_toe(0));
  CHECK(of_one > 0.5f);  // .36 if the bound were a measurement of both sides
  CHECK(of_one < 0.6f * uncertainty_of_toe(0));
  CHECK(uncertainty_of_toe(5) == Approx(of_one).epsilon(1e-3));
}

TEST_CASE("the estimate knows where it is unsure: in codes that no pair of frames compared") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  const Response found = estimated(exposed(scene, 6)).response;
  const Response nothing_seen = ResponseEstimator().estimate({}).response;
  for (int c = 0; c < 3; ++c) {
    INFO("channel " << c);
    CHECK(found.uncertainty(c, 60) < 0.5f * nothing_seen.uncertainty(c, 60));
    CHECK(found.uncertainty(c, 1) > 3 * found.uncertainty(c, 110));
    CHECK(Response::gamma(2.2f).uncertainty(c, 60) == 0);
  }
}

TEST_CASE("a black level is found together with the response") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  scene.sensitivity = 60;  // a dark scene: black pixels are there to be seen
  scene.black_level = 14;
  const auto estimate = estimated(exposed(scene, 6));
  for (std::size_t c = 0; c < 3; ++c) CHECK(estimate.black_level[c] == Approx(14).margin(0.5));
  CHECK(response_error(estimate.response, Response::gamma(2.2f)) < 0.06);
}

TEST_CASE("black levels differ by channel, and compression makes some pixels darker than black") {
  constexpr std::array<float, 3> kBlack{18, 12, 0};
  const Response response = prior_mean_response();
  std::vector<ExposedFrame> frames;
  for (const float exposure : {0.25f, 2.f, 16.f})
    frames.push_back(frame_of(exposure, [&](int c, int y, int x) {
      const double light = std::exp2(-5.5 + 5.5 * std::sin(x * 0.06) * std::cos(y * 0.05));
      const float code = response.code_of(c, std::min(1.f, exposure * static_cast<float>(light)));
      const float black = kBlack[static_cast<std::size_t>(c)];
      const bool darkened = (x + 37 * y) % 100 == 0;
      return darkened ? 0 : std::round(black + code * (255 - black) / 255);
    }));
  const auto estimate = estimated(frames);
  for (std::size_t c = 0; c < 3; ++c) CHECK(estimate.black_level[c] == Approx(kBlack[c]).margin(0.5));
  CHECK(response_error(estimate.response, response) < 0.01);
}

TEST_CASE("dark codes of more bits are matched as finely as they are") {
  const std::vector<int> keys{0, 64};  // a stop apart
  HistogramMatches::OfChannel matches;
  CodeMatches& pair = matches[{keys[0], keys[1]}];
  pair.log_ratio = -std::log(2);
  pair.codes = {{4, 8}};
  const Eigen::VectorXd as_stated = Eigen::VectorXd::Zero(shared_unknowns::count(keys));
  const auto told_by = [&](float code_step) {
    const NoiseModel quiet{.full_well = 1e7f, .read_noise = 0, .code_noise = 0, .code_step = code_step};
    CurveSquares squares(as_stated.size());
    add_match_evidence(matches, 0, {quiet, true}, curve_prior().mean, {keys, as_stated}, squares);
    return squares.A(3, 3);  // of code 4
  };
  CHECK(told_by(1 / 16.f) > 4 * told_by(1));
}

TEST_CASE("pairs that say nothing are left out") {
  test::MovingScene scene;
  auto frames = exposed(scene, 4);
  ResponseEstimator estimator;
  SECTION("of the same exposure") { CHECK_FALSE(estimator.add_pair(frames[0], frames[3])); }
  SECTION("of unproved exposure") {
    frames[1].facts.flags |= kFrameExposureUnproved;
    CHECK_FALSE(estimator.add_pair(frames[0], frames[1]));
  }
  SECTION("of a damaged picture") {
    frames[1].facts.flags |= kFrameDamaged;
    CHECK_FALSE(estimator.add_pair(frames[0], frames[1]));
    CHECK_FALSE(estimator.add_pair(frames[1], frames[2]));
  }
  SECTION("across a scene cut") {
    frames[1].codes = another_scene(scene.rows, scene.cols, 128, 100);
    CHECK_FALSE(estimator.add_pair(frames[0], frames[1]));
  }
  for (const float code : {0.f, 255.f}) SECTION(code > 0 ? "of white frames" : "of black frames") {
      for (ExposedFrame& frame : frames) frame.codes.fill(code);
      CHECK_FALSE(estimator.add_pair(frames[0], frames[1]));
    }
  CHECK(estimator.pairs() == 0);
  CHECK(response_error(estimator.estimate({}).response, prior_mean_response()) < 1e-3);
}

TEST_CASE(
    "exposures that go on changing, as with the light, are kept as far back as they tell, not for ever") {
  HistogramMatches matches;
  const auto shown = [](float exposure) {
    return frame_of(exposure, [&](int, int y, int x) {
      return 255 * std::sqrt(std::min(1.f, exposure * static_cast<float>(x + y) / 900));
    });
  };
  constexpr int kPairs = 2 * static_cast<int>(HistogramMatches::kMostPairs);
  for (int i = 0; i < kPairs; ++i) {
    const float exposure = std::exp2(static_cast<float>(i) / 32);
    REQUIRE(matches.add(shown(exposure / 8), shown(exposure / 2), SceneCuts::None));
  }
  CHECK(matches.pairs() == kPairs);
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(matches.of(c).size() == HistogramMatches::kMostPairs);
    CHECK(matches.of(c).begin()->second.newest == kPairs - static_cast<int>(HistogramMatches::kMostPairs));
  }
}

TEST_CASE("of one pair of exposures the matches of the newest frames are kept, however long the stream") {
  constexpr std::size_t kKept = 25 * std::size_t{HistogramMatches::kQuantiles}, kPairs = 40;
  HistogramMatches matches;
  const auto shown = [](float exposure) {
    return frame_of(exposure, [&](int, int y, int x) {
      return 255 * std::sqrt(exposure * static_cast<float>(x + y) / 900);
    });
  };
  const ExposedFrame shorter = shown(0.5f), longer = shown(1);
  std::size_t of_one = 0;
  for (std::size_t pair = 0; pair < kPairs; ++pair) {
    REQUIRE(matches.add(shorter, longer, SceneCuts::None));
    for (std::size_t c = 0; c < 3; ++c) {
      REQUIRE(matches.of(c).size() == 1);
      const std::vector<CodeMatch>& codes = matches.of(c).begin()->second.codes;
      if (pair == 0 && c == 0) of_one = codes.size();
      REQUIRE(codes.size() == std::min(kKept, (pair + 1) * of_one));
    }
  }
  CHECK(kPairs * of_one > kKept);
  CHECK(matches.of(0).begin()->second.pairs == static_cast<int>(kPairs));
}

TEST_CASE("a step of four stops over lamps and shadows is no scene cut") {
  // Where it is darker there are more lamps. They count for most of a short exposure's mean, and are clipped
  // in the long one, so that the means of the two go opposite ways.
  const Response response = Response::gamma(2.2f);
  const auto exposed_by = [&](float exposure, int shift) {
    return frame_of(exposure, [&](int c, int y, int x) {
      const double darkness = 0.5 + 0.5 * std::sin((x + shift) * 0.06) * std::cos(y * 0.05);
      const double chance = test::MovingScene::noise(static_cast<std::uint64_t>(y * 4096 + x + shift));
      const bool lamp = chance > 1.28 - 0.7 * darkness;  // a tenth to a third of the pixels
      const double light = lamp ? 1 : std::exp2(-4 - 1.5 * darkness);
      return std::round(response.code_of(c, std::min(1.f, exposure * static_cast<float>(light))));
    });
  };
  CHECK(ResponseEstimator().add_pair(exposed_by(0.25f, 0), exposed_by(4, 2)));
}

TEST_CASE("where the system starts no thread, the response is learned as well without one") {
  constexpr int kFirst = 6;
  const test::MovingScene scene;
  const auto frames = exposed(scene, 12);
  const ExposedFrame wall = frame_of(1, [](int, int, int) { return 128.f; });
  const auto answers = [&](bool refused) {
    ResponseLearner learner({});
    std::vector<CompactFrame> first;
    for (int i = 0; i < kFirst; ++i) {
      learner.see_first(wall, i > 0 ? &first.back() : nullptr);
      first.emplace_back(wall, 8);
    }
    WorkerPool pool(1);
    (void)learner.first(first, {}, pool);
    std::optional<test::RefusedThreads> refusal;
    if (refused) refusal.emplace();
    std::vector<double> uncertainties;  // of each frame's answer; 0: none
    for (std::size_t i = 0; i < 40; ++i)
      uncertainties.push_back(learner.next(frames[i % frames.size()], {}) ? learner.uncertainty() : 0);
    return uncertainties;
  };
  const std::vector<double> usual = answers(false);
  CHECK(std::ranges::any_of(usual, [](double uncertainty) { return uncertainty > 0; }));
  CHECK(answers(true) == usual);
}
