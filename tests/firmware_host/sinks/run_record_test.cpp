#include "firmware_host/sinks/run_record.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/firmware_host/sinks/example_run.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("stage times are summarised over the frames in which the stage ran") {
  RunRecord record;
  for (int i = 1; i <= 100; ++i) {
    FrameRecord frame;
    frame.total_ms = i;
    frame.stages_ms = {{"state", i * 0.5}};
    if (i > 90) frame.stages_ms.push_back({"field", 20});
    record.frames.push_back(frame);
  }
  const auto stages = stage_summaries(record);
  REQUIRE(stages.size() == 3);
  CHECK(stages[0].name == "state");
  CHECK(stages[0].mean_ms == Approx(25.25));
  CHECK(stages[0].p95_ms == Approx(47.5));
  CHECK(stages[0].max_ms == Approx(50));
  CHECK(stages[1].name == "field");
  CHECK(stages[1].frames == 10);
  CHECK(stages[1].mean_ms == Approx(20));
  CHECK(stages[2].name == "total");
  CHECK(stages[2].p95_ms == Approx(95));
  CHECK(mean_ms_per_frame(record) == Approx(50.5));
}

TEST_CASE("a run without frames has zeros, not divisions by zero") {
  const RunRecord empty;
  CHECK(mean_ms_per_frame(empty) == 0);
  REQUIRE(stage_summaries(empty).size() == 1);
  CHECK(stage_summaries(empty)[0].p95_ms == 0);
  CHECK(nlohmann::json::parse(to_json(empty))["frames"] == 0);
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
}

TEST_CASE("numbers that are not finite and text that is not UTF-8 still make valid JSON") {
  RunRecord record = test::example_run(1);
  record.frames[0].losses = {{"photometric", std::numeric_limits<double>::quiet_NaN()}};
  record.command = "hdrcam replay caf\xe9.mkv";
  const auto json = nlohmann::json::parse(to_json(record));
  CHECK(json["per_frame"][0]["losses"]["photometric"].is_null());
}
