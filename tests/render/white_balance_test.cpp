#include "render/white_balance.h"

#include "tests/firmware_host/sinks/example_frames.h"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

TEST_CASE("the gains of the camera multiply the radiance, and the frame says which they were") {
  const HdrFrame before = test::example_frame(1);
  HdrFrame frame = test::example_frame(1);
  frame.points.push_back({Eigen::Vector3d::Zero(), 1, 1, {1, 2, 3}});
  apply_white_balance({2, 1, 1.5}, frame);
  const float gains[] = {2, 1, 1.5f};
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < before.radiance.rows(); ++y)
      for (int x = 0; x < before.radiance.cols(); ++x) {
        if (before.radiance.at(c, y, x) >= 0.98f * before.white) continue;
        REQUIRE(frame.radiance.at(c, y, x) == before.radiance.at(c, y, x) * gains[c]);
      }
  CHECK(frame.points[0].radiance == std::array<float, 3>{2, 2, 4.5f});
  CHECK(frame.white == 2 * before.white);
  CHECK(frame.white_balance == ChannelGains{2, 1, 1.5});
}

TEST_CASE("what is clipped in all exposures stays white, and what is a true colour keeps it") {
  HdrFrame frame = test::example_frame(1, test::With::RadianceOnly, 1, 4);
  const auto pixel = [&](int x, std::array<float, 3> rgb, Provenance from) {
    for (int c = 0; c < 3; ++c) frame.radiance.at(c, 0, x) = rgb[static_cast<std::size_t>(c)];
    frame.provenance.at(0, 0, x) = static_cast<std::uint8_t>(from);
  };
  const auto shown = [&](int x) {
    return std::array<float, 3>{frame.radiance.at(0, 0, x), frame.radiance.at(1, 0, x),
                                frame.radiance.at(2, 0, x)};
  };
  pixel(0, {16, 16, 16}, Provenance::Bound);  // white is 16
  pixel(1, {12, 16, 10}, Provenance::Bound);  // green alone is clipped
  pixel(2, {12, 16, 10}, Provenance::Own);
  pixel(3, {2, 3, 4}, Provenance::Bound);
  apply_white_balance({2, 1, 1.5}, frame);
  CHECK(shown(0) == std::array<float, 3>{32, 32, 32});
  CHECK(shown(1) == std::array<float, 3>{24, 24, 15});
  CHECK(shown(2) == std::array<float, 3>{24, 16, 15});
  CHECK(shown(3) == std::array<float, 3>{4, 3, 6});
}

TEST_CASE("the light that leaves is neutral where white is, and balanced as it is wanted") {
  HdrFrame frame = test::example_frame(1);
  frame.neutral_gains = ChannelGains{0.5, 1, 2};
  balance_colours(ChannelGains{2, 1, 1.5}, frame);
  CHECK(frame.white_balance == ChannelGains{1, 1, 3});
  CHECK_FALSE(frame.neutral_gains);  // they are applied
  balance_colours(std::nullopt, frame);
  CHECK(frame.white_balance == ChannelGains{1, 1, 3});

  HdrFrame neutral = test::example_frame(1);
  balance_colours(std::nullopt, neutral);
  CHECK_FALSE(neutral.white_balance);
  CHECK(std::ranges::equal(neutral.radiance.samples(), test::example_frame(1).radiance.samples()));
}

TEST_CASE("a white balance that the camera does not state is an error where it is wanted") {
  CameraFacts camera;
  camera.name = "walk";
  const WhiteBalance none = CameraColours(), as_camera = CameraGains();
  CHECK_FALSE(white_balance_gains(none, camera).value());
  const auto missing = white_balance_gains(as_camera, camera);
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().code == ErrorCode::Unsupported);
  CHECK_THAT(missing.error().message, Contains("'walk'") && Contains("--white-balance"));
  camera.name.clear();
  CHECK(
      white_balance_gains(as_camera, camera).error().message.starts_with("the clip states no white balance"));
  camera.white_balance = ChannelGains{2, 1, 1.5};
  CHECK(white_balance_gains(as_camera, camera).value() == camera.white_balance);
  CHECK_FALSE(white_balance_gains(none, camera).value());
}

TEST_CASE("a white balance is a word, or three gains that a camera can have") {
  CHECK(std::holds_alternative<CameraColours>(parse_white_balance("none").value()));
  CHECK(std::holds_alternative<CameraGains>(parse_white_balance("camera").value()));
  CHECK(std::get<ChannelGains>(parse_white_balance("2,1,1.5").value()) == ChannelGains{2, 1, 1.5});
  CHECK(white_balance_gains(*parse_white_balance("2,1,1.5"), {}).value() == ChannelGains{2, 1, 1.5});
  for (const char* wrong : {"", "auto", "2", "2,1", "2,1,", ",1,2", "2,1,1.5,1", "2,0,1", "2,-1,1", "2,1,65",
                            "2,nan,1", "2, 1,1", "2,1,1.5x"}) {
    INFO(wrong);
    CHECK_FALSE(parse_white_balance(wrong));
  }
}
