#include "firmware_host/sinks/run_record.h"

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
}
