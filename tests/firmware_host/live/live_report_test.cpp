// What the end of a run on a camera says of frames that were dropped.
#include "firmware_host/live/live_report.h"

#include <catch2/catch.hpp>

#include "hal/core/stage_timing.h"

namespace hdrcam {
namespace {

// Frames on which the method works for so long, and which wait as long for the outputs.
RunRecord record_of(double method_ms, double outputs_ms) {
  RunRecord record;
  for (int i = 0; i < 8; ++i) {
    FrameRecord frame;
    frame.total_ms = method_ms + outputs_ms;
    frame.stages_ms = {{name(Stage::Sinks), outputs_ms}};
    record.frames.push_back(frame);
  }
  return record;
}

Settings settings_with_outputs() {
  Settings settings;
  settings.camera.id = "sim:walk";
  settings.output.paths["frames"] = "out/%06d.exr";
  settings.output.paths["video"] = "out.mp4";
  settings.output.paths["preview"] = "out/%06d.png";
  return settings;
}

LiveCounters with_shed_frames() {
  LiveCounters counters;
  counters.shed = 20;
  return counters;
}

TEST_CASE("where the fit waits for its outputs longer than it works, the slowest of them is named") {
  const Settings settings = settings_with_outputs();
  RunRecord record = record_of(12, 130);
  record.sinks = {
      {.name = "frames", .frames = 8, .total_ms = 160},
      {.name = "video", .frames = 8, .total_ms = 1152},
      {.name = "preview", .frames = 8, .left_out = 90, .total_ms = 2000}};  // keeps nobody waiting
  const std::string slow = advice_to_keep_up(with_shed_frames(), settings, record);
  CHECK_THAT(slow, Catch::StartsWith("the output 'out.mp4' (144 ms a frame; the fit 12 ms) did not keep up"));
  CHECK_THAT(slow, !Catch::Contains("--preset"));
  record.frames = record_of(60, 20).frames;
  CHECK_THAT(advice_to_keep_up(with_shed_frames(), settings, record),
             Catch::StartsWith("the fit did not keep up with the camera; give --preset realtime"));
  CHECK(advice_to_keep_up({}, settings, record).empty());
}

TEST_CASE(
    "a recording at a camera's pace has all frames without that pace, and without a deadline of its own") {
  Settings settings = settings_with_outputs();
  settings.camera.id = "replay:walk.mkv";
  CHECK(
      advice_to_keep_up(with_shed_frames(), settings, record_of(60, 20)) ==
      "the fit did not keep up with the recording; leave out --pace realtime, and every frame is worked on");
  LiveCounters late;
  late.left_out = 8;
  settings.fit.deadline = "1ms";
  CHECK_THAT(advice_to_keep_up(late, settings, record_of(60, 20)),
             Catch::Contains("leave out --pace realtime and --deadline, and every frame"));
}

TEST_CASE("pictures that contradict more than every tenth exposure of a camera lead to its lamps") {
  Settings settings = settings_with_outputs();
  LiveCounters counters;
  counters.camera.emitted = 60, counters.camera.contradicted = 27;
  CHECK_THAT(advice_on_light(counters, settings),
             Catch::Contains("the exposures of 27 of 60 frames") && Catch::Contains("--mains 50 or 60"));
  settings.schedule.mains = Mains::Hz50;  // then a note says at the start which exposures will flicker
  CHECK(advice_on_light(counters, settings).empty());
  settings.schedule.mains = Mains::Off, settings.camera.id = "replay:walk.mkv";
  CHECK(advice_on_light(counters, settings).empty());
  settings.camera.id = "sim:night";
  counters.camera.contradicted = 6;
  CHECK(advice_on_light(counters, settings).empty());
  counters.camera.emitted = 20, counters.camera.contradicted = 8;  // of a start with a wrong control delay
  CHECK(advice_on_light(counters, settings).empty());
}

}  // namespace
}  // namespace hdrcam
