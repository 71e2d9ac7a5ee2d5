#include "firmware_host/sinks/stats.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/firmware_host/sinks/example_run.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the statistics of a run without frames are JSON too") {
  CHECK(nlohmann::json::parse(to_json(RunRecord{}))["frames"] == 0);
}

TEST_CASE("the statistics say what each sink cost and what it left out") {
  RunRecord record = test::example_run(4);
  record.sinks = {{.name = "preview", .frames = 3, .left_out = 1, .total_ms = 30, .longest_ms = 14}};
  const auto preview = nlohmann::json::parse(to_json(record))["sinks"]["preview"];
  CHECK(preview["frames"] == 3);
  CHECK(preview["mean_ms"] == 10);
  CHECK(preview["max_ms"] == 14);
  CHECK(preview["left_out"] == 1);
}

TEST_CASE("the statistics are JSON with the fields that scripts rely on") {
  const auto json = nlohmann::json::parse(to_json(test::example_run(48)));
  CHECK(json["frames"] == 48);
  CHECK(json["captured"] == json["emitted"].get<int>() + json["dropped"].get<int>());
  CHECK(json["ms_per_frame"].get<double>() > 0);
  for (const char* key : {"mean_ms", "p95_ms", "max_ms"}) CHECK(json["stages"]["state"][key].is_number());
  CHECK(json["stages"]["total"]["frames"] == 48);
  REQUIRE(json["per_frame"].size() == 48);
  const auto& frame = json["per_frame"][7];
  CHECK(frame["sequence"] == 7);
  CHECK(frame["stages_ms"]["field"].is_number());
  CHECK(frame["losses"]["photometric"].is_number());
  CHECK(frame["provenance"]["look_ahead"].is_number());
  CHECK(json["scores"]["PSNR-mu"]["unit"] == "dB");
  CHECK(json["response"].size() == 3);
  CHECK(json["response"][0].size() == 256);
  REQUIRE(json["exposures"].size() == 3);
  CHECK(json["exposures"][1]["stated"] == 1);
  CHECK(json["exposures"][1]["off_stops"].get<float>() == -0.06f);
}

TEST_CASE("the statistics state the pose of each frame that has one, its source and its unit") {
  RunRecord record = test::example_run(3);
  record.frames[1].pose = FramePose{{Eigen::Matrix3d::Identity(), {1, 2, 3}}, PoseSource::Tracked, true, 2};
  record.frames[2].pose = FramePose{};
  const auto frames = nlohmann::json::parse(to_json(record))["per_frame"];
  CHECK_FALSE(frames[0].contains("pose"));
  const auto& pose = frames[1]["pose"];
  CHECK(pose["source"] == "tracked");
  CHECK(pose["length_unit"] == "median depth of the first view");
  CHECK(pose["T_world_camera"] ==
        nlohmann::json({1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 1.0, 3.0}));
  CHECK((pose["lost"] == true && pose["world"] == 2));
  CHECK(frames[2]["pose"]["source"] == "given");
  CHECK_FALSE((frames[2]["pose"].contains("lost") || frames[2]["pose"].contains("world")));
}

TEST_CASE("the shares of provenance are right in pictures of more pixels than a float counts") {
  Image<std::uint8_t> provenance(1, 5000, 5000);  // a float counts to 2^24
  provenance.fill(static_cast<std::uint8_t>(Provenance::Carried));
  for (int y = 0; y < 1000; ++y)
    std::fill_n(provenance.row(0, y), 5000, static_cast<std::uint8_t>(Provenance::Bound));
  const auto shares = provenance_shares(provenance);
  CHECK(shares[static_cast<std::size_t>(Provenance::Carried)] == Approx(0.8));
  CHECK(shares[static_cast<std::size_t>(Provenance::Bound)] == Approx(0.2));
  CHECK(shares[static_cast<std::size_t>(Provenance::Own)] == 0);
}

TEST_CASE("numbers that are not finite and text that is not UTF-8 still make valid JSON") {
  RunRecord record = test::example_run(1);
  record.frames[0].losses = {{"photometric", std::numeric_limits<double>::quiet_NaN()}};
  record.command = "hdrcam replay caf\xe9.mkv";
  const auto json = nlohmann::json::parse(to_json(record));
  CHECK(json["per_frame"][0]["losses"]["photometric"].is_null());
}
