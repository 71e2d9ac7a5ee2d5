#include "firmware_host/percent_text.h"

#include "firmware_host/sinks/report.h"
#include "tests/firmware_host/sinks/example_run.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

TEST_CASE("a share with decimals is 100.0 percent only where it is all") {
  CHECK(percent_text(0) == "0.0");
  CHECK(percent_text(0.375) == "37.5");
  CHECK(percent_text(0.7f) == "70.0");
  CHECK(percent_text(0.9996) == "99.9");
  CHECK(percent_text(1) == "100.0");
}

TEST_CASE("the report shows 100.0 percent of a source only where all pixels have it") {
  RunRecord record = test::example_run(10);  // ten tenths are less than one, in floating point
  for (FrameRecord& frame : record.frames) frame.provenance_share = {1, 0, 0, 0, 0};
  CHECK_THAT(report_html(record, {}), Contains("<td class=\"n\">100.0 %</td>"));
  record.frames[7].provenance_share = {0.996f, 0.004f, 0, 0, 0};
  const std::string html = report_html(record, {});
  CHECK_THAT(html, Contains("<td class=\"n\">99.9 %</td>"));
  CHECK_THAT(html, !Contains("100.0 %"));
}
