#include "firmware_host/whole_percent.h"

#include "firmware_host/live/live_report.h"
#include "firmware_host/sinks/report.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

TEST_CASE("a share is 100 percent only where it is all") {
  CHECK(whole_percent(0, 0) == 0);
  CHECK(whole_percent(0, 7) == 0);
  CHECK(whole_percent(57, 100) == 57);
  CHECK(whole_percent(299, 300) == 99);
  CHECK(whole_percent(300, 300) == 100);
}

TEST_CASE("one late frame of many keeps the report from 100 percent within the deadline") {
  RunRecord record;
  record.captured = record.emitted = 1000;
  record.deadline_ms = 40, record.late = 1;
  CHECK_THAT(report_html(record, {}),
             Contains("\"good\">99 <small>%</small></b><span>of frames within 40.0 ms"));
}

TEST_CASE("one unproved frame of many keeps the status line from an exposure proved in all") {
  LiveCounters counters;
  counters.camera.emitted = 1000, counters.camera.proved = 999;
  CHECK_THAT(live_line(1, counters, LiveWork::Fit), Contains("exposure proved 99 %"));
  counters.camera.proved = 1000;
  CHECK_THAT(live_line(1, counters, LiveWork::Fit), Contains("exposure proved 100 %"));
}
