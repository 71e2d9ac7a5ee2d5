#include "firmware_host/sinks/stats.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "firmware_host/live/live_report.h"
#include "tests/firmware_host/sinks/example_run.h"
#include "tests/places.h"

#include "tests/support/files.h"

using namespace hdrcam;

namespace {

// In the table of docs/stats.md whose first column has this head: what stands in that column in backticks.
std::set<std::string> documented_keys(const std::string& head) {
  std::istringstream page(test::text_of(HDRCAM_SOURCE_DIR "/docs/stats.md"));
  std::set<std::string> keys;
  bool in_table = false;
  for (std::string line; std::getline(page, line);) {
    in_table = line.starts_with("| " + head + " |") || (in_table && line.starts_with('|'));
    if (!in_table) continue;
    std::istringstream column(line.substr(0, line.find('|', 1)));
    std::string between, key;
    while (std::getline(column, between, '`') && std::getline(column, key, '`')) keys.insert(key);
  }
  return keys;
}

std::set<std::string> keys_of(const nlohmann::json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

}  // namespace

TEST_CASE("the statistics of a run without frames are JSON too") {
  CHECK(nlohmann::json::parse(to_json(RunRecord{}))["frames"] == 0);
}

TEST_CASE("the statistics are written as JSON of one piece, a line each and a blank a level") {
  for (const int frames : {0, 1, 5}) {
    CAPTURE(frames);
    RunRecord record = test::example_run(frames);
    record.title = "a { \"name\" }\n}";
    const std::string text = to_json(record);
    const auto json = nlohmann::ordered_json::parse(text);
    CHECK(json["per_frame"].size() == static_cast<std::size_t>(frames));
    CHECK(text == json.dump(1) + '\n');
  }
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
  RunRecord record = test::example_run(48);
  record.captured = 51, record.dropped = 3;
  const auto json = nlohmann::json::parse(to_json(record));
  CHECK(json["frames"] == 48);
  CHECK(json["captured"] == 51);
  CHECK(json["emitted"] == 48);
  CHECK(json["dropped"] == 3);
  CHECK(json["ms_per_frame"].get<double>() == Approx(mean_ms_per_frame(record)));
  const auto summaries = stage_summaries(record);
  CHECK(json["stages"].size() == summaries.size());
  for (const StageSummary& stage : summaries) {
    INFO(stage.name);
    const auto& stated = json["stages"][stage.name];
    CHECK(stated["frames"] == stage.frames);
    CHECK(stated["mean_ms"].get<double>() == Approx(stage.mean_ms));
    CHECK(stated["p95_ms"].get<double>() == Approx(stage.p95_ms));
    CHECK(stated["max_ms"].get<double>() == Approx(stage.max_ms));
  }
  REQUIRE(json["per_frame"].size() == 48);
  const auto& frame = json["per_frame"][7];
  const FrameRecord& seventh = record.frames[7];
  CHECK(frame["sequence"] == 7);
  CHECK(frame["total_ms"].get<double>() == Approx(seventh.total_ms));
  REQUIRE(seventh.stages_ms[2].name == "field");
  CHECK(frame["stages_ms"]["field"].get<double>() == Approx(seventh.stages_ms[2].value));
  REQUIRE(seventh.losses[0].name == "photometric");
  CHECK(frame["losses"]["photometric"].get<double>() == Approx(seventh.losses[0].value));
  CHECK(frame["provenance"]["look_ahead"].get<double>() ==
        Approx(seventh.provenance_share[static_cast<std::size_t>(Provenance::LookAhead)]));
  CHECK(json["provenance"]["carried"].get<double>() ==
        Approx(mean_provenance(record)[static_cast<std::size_t>(Provenance::Carried)]));
  CHECK(json["scores"]["PSNR-mu"]["value"] == 38.1);
  CHECK(json["scores"]["PSNR-mu"]["unit"] == "dB");
  REQUIRE(json["response"].size() == 3);
  REQUIRE(json["response"][0].size() == 256);
  CHECK(json["response"][1][100].get<float>() == (*record.response)[1][100]);
  REQUIRE(json["exposures"].size() == 3);
  CHECK(json["exposures"][1]["stated"] == 1);
  CHECK(json["exposures"][1]["off_stops"].get<float>() == -0.06f);
}

TEST_CASE("the statistics have the keys that docs/stats.md lists, and no others") {
  RunRecord record = test::example_run(6);
  record.rungs = {{.name = "as asked", .frames = 6}};
  record.counters = {{"dropped.shed", 2}};
  record.light_spread_stops = 0.2;
  FrameRecord& frame = record.frames[5];  // which has a note
  frame.pose = FramePose{};
  frame.verdict = Verdict::Proved;
  frame.latency_ms = 40;
  const auto json = nlohmann::json::parse(to_json(record));
  CHECK(keys_of(json) == documented_keys("key"));
  CHECK(keys_of(json["per_frame"][5]) == documented_keys("key of a frame"));
}

TEST_CASE("the counters of a run on a camera are those that docs/stats.md lists") {
  LiveCounters counters;
  counters.camera.trigger.pulses = 1;
  std::set<std::string> names;
  for (const NamedValue& counter : named(counters)) names.emplace(counter.name);
  CHECK(names == documented_keys("counter"));
}

TEST_CASE("counts are whole numbers in JSON, and times beside them may be fractions") {
  RunRecord record = test::example_run(2);
  record.counters = {{"captured", 31}, {"first_frame_ms", 179.5}};
  const auto counters = nlohmann::json::parse(to_json(record))["counters"];
  CHECK(counters["captured"].is_number_integer());
  CHECK(counters["captured"] == 31);
  CHECK(counters["first_frame_ms"] == 179.5);
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
