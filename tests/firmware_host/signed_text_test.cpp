#include "firmware_host/signed_text.h"

#include "firmware_host/commands/recording_summary.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

TEST_CASE("a number is shown with its sign, and zero never as below zero") {
  CHECK(signed_text(0.334, 2) == "+0.33");
  CHECK(signed_text(-2, 2) == "-2.00");
  CHECK(signed_text(-0.006, 2) == "-0.01");
  for (const double zero : {0.0, -0.0, 0.0024, -0.0024}) CHECK(signed_text(zero, 2) == "+0.00");
  CHECK(signed_text(-0.04, 1) == "+0.0");
  CHECK(signed_text(-0.4, 0) == "+0");
}

TEST_CASE("info shows a slot of nearly the reference exposure as +0.00 EV") {
  RecordingSummary summary;
  summary.camera.framerate_hz = 30;
  summary.cycle = {.period = 3, .exposures = {1e-3, 3.99e-3, 16e-3}};
  CHECK_THAT(as_table(summary, "walk.mkv"), Contains("3 slots: -2.00 / +0.00 / +2.00 EV"));
}
