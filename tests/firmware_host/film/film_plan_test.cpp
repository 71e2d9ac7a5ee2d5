#include "firmware_host/film/film_plan.h"

#include <fstream>

#include "hal/recording/recording.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

constexpr FilmedRecording kWalk{.duration_s = 2, .framerate_hz = 30, .width = 320, .height = 240};

Result<FilmPlan> planned(const FilmOptions& options, const FilmedRecording& recording = kWalk,
                         const Settings::Fit& fit = {}) {
  return plan_film(posix_storage(), options, fit, recording);
}

std::string refusal(const FilmOptions& options, const FilmedRecording& recording = kWalk,
                    const Settings::Fit& fit = {}) {
  const auto plan = planned(options, recording, fit);
  REQUIRE_FALSE(plan.ok());
  CHECK(plan.error().code == ErrorCode::Invalid);
  return plan.error().message;
}

}  // namespace

TEST_CASE("a film of everything as it is has the recording's frames, rate and size", "[film]") {
  const FilmPlan plan = planned({}).value();
  CHECK(plan.frames == 61);
  CHECK(plan.framerate_hz == 30);
  CHECK(plan.width == 320);
  CHECK(plan.scene_s(60) == Approx(2));
  CHECK(plan.shutter_s == 0);
}

TEST_CASE("slow motion has more frames, each a part of a frame later; a higher rate likewise", "[film]") {
  const FilmPlan slow = planned({.speed = 0.25}).value();
  CHECK(slow.frames == 241);
  CHECK(slow.scene_s(1) == Approx(1 / 120.0));
  CHECK(slow.playback_s(1) == Approx(1 / 30.0));
  const FilmPlan fluent = planned({.framerate_hz = 120}).value();
  CHECK(fluent.frames == 241);
  CHECK(fluent.scene_s(1) == Approx(1 / 120.0));
  CHECK(fluent.playback_s(1) == Approx(1 / 120.0));
}

TEST_CASE("a moment is one frame, a part has its own beginning and end", "[film]") {
  const FilmPlan still = planned({.time = "0.5"}).value();
  CHECK(still.frames == 1);
  CHECK(still.frozen);
  CHECK(still.scene_s(0) == 0.5);
  const FilmPlan part = planned({.time = "0.5s..1.5s"}).value();
  CHECK(part.frames == 31);
  CHECK(part.scene_s(0) == 0.5);
  CHECK_FALSE(part.frozen);
  CHECK(planned({.time = "500ms..1.5s"}).value().scene_s(0) == 0.5);
  CHECK(planned({.time = "end"}).value().scene_s(0) == 2);
  CHECK(planned({.time = "1.5..end"}).value().frames == 16);
}

TEST_CASE("a film of a snapshot spans the snapshot's own times, and needs its field for another view",
          "[film]") {
  FilmedRecording snapshot = kWalk;
  snapshot.begin_s = 1.5, snapshot.kind = FilmedKind::Snapshot;
  const FilmPlan plan = planned({}, snapshot).value();
  CHECK(plan.scene_s(0) == 1.5);
  CHECK(plan.frames == 16);
  CHECK(planned({.view = "0.1,0,0", .time = "1.5"}, snapshot).ok());
  CHECK_THAT(refusal({.time = "1.4"}, snapshot), Contains("outside the snapshot, which spans 1.5 to 2 s"));
  snapshot.kind = FilmedKind::SnapshotWithoutField;
  CHECK(planned({.time = "1.6"}, snapshot).ok());
  for (const char* view : {"0.1,0,0", "10cm,0,0"})
    CHECK_THAT(refusal({.view = view}, snapshot), Contains("the snapshot was saved without one"));
}

TEST_CASE("a length in metres is refused of a snapshot whose camera was taken to stand still", "[film]") {
  FilmedRecording snapshot = kWalk;
  snapshot.kind = FilmedKind::Snapshot, snapshot.stands_still = true;
  CHECK_THAT(refusal({.view = "63mm,0,0"}, snapshot),
             Contains("shows no length; save the scene without --set pose=fixed") && !Contains("tracked"));
  CHECK(planned({.view = "0.02,0,0"}, snapshot).ok());
}

TEST_CASE("the times of a film count from the time stamp of the recording's first frame", "[film]") {
  const std::string path = sample::scratch_folder("film_plan") + "/clip.mkv";
  const test::MovingScene scene;
  auto writer = create_recording(posix_storage(), path, scene.camera()).value();
  for (const int frame : {6, 9, 12}) REQUIRE(writer->append(scene.frame(frame)).ok());
  REQUIRE(writer->finish().ok());
  std::atomic<bool> stop{false};
  const FilmedRecording recording = look_through(posix_storage(), path, stop).value();
  CHECK(recording.first.seconds() == Approx(0.2));
  CHECK(recording.duration_s == Approx(0.2));
  CHECK(planned({.time = "0.1"}, recording).value().first == recording.first);
  stop = true;  // a long recording takes minutes
  CHECK(sample::error_of(look_through(posix_storage(), path, stop)).code == ErrorCode::Interrupted);
}

TEST_CASE("the shutter angle is the share of a film frame's own time", "[film]") {
  const FilmPlan plan = planned({.speed = 0.5, .shutter_deg = 180}).value();
  CHECK(plan.shutter_s == Approx(0.5 / 30));
  CHECK(plan.scene_shutter_s() == Approx(0.5 * 0.5 / 30));
  FilmPlan frozen = planned({.time = "0.5", .shutter_deg = 180}).value();
  CHECK(frozen.scene_shutter_s() == Approx(0.5 / 30));  // a photograph
  const std::string path = sample::scratch_folder("film_shutter") + "/p.csv";
  std::ofstream(path) << "time_s,dx\n0,0\n1,0.1\n";
  frozen = planned({.path = path, .time = "0.5", .shutter_deg = 180}).value();
  CHECK(frozen.shutter_s == Approx(0.5 / 30));
  CHECK(frozen.scene_shutter_s() == 0);
}

TEST_CASE("a frozen moment has no speed, but for the blur of a photograph", "[film]") {
  CHECK_THAT(refusal({.time = "0.5", .speed = 0.25}),
             Contains("--time 0.5 freezes a moment") && Contains("leave out --speed"));
  const std::string path = sample::scratch_folder("film_frozen_speed") + "/p.csv";
  std::ofstream(path) << "time_s,dx\n0,0\n1,0.1\n";
  CHECK_THAT(refusal({.path = path, .time = "0.5", .speed = 2, .shutter_deg = 180}),
             Contains("leave out --speed"));
  const FilmPlan photograph = planned({.time = "0.5", .speed = 0.25, .shutter_deg = 180}).value();
  CHECK(photograph.scene_shutter_s() == Approx(0.25 * 0.5 / 30));
  CHECK(planned({.time = "0.5", .speed = 1}).ok());
  CHECK(planned({.time = "0.5..1", .speed = 0.25}).ok());
}

TEST_CASE("an exposure makes 8-bit pictures, at the reference exposure where none is named", "[film]") {
  CHECK_FALSE(planned({}).value().exposure);
  CHECK(planned({.ldr = true}).value().exposure == 0.0);
  CHECK(*planned({.exposure = "1/250"}).value().exposure == Approx(0.004));
  FilmedRecording relative = kWalk;  // whose exposures were estimated from its pictures
  relative.has_exposure_times = false;
  CHECK(planned({.ldr = true}, relative).value().exposure == 0.0);
  CHECK_THAT(refusal({.exposure = "1/250"}, relative), Contains("only the ratios are known"));
}

TEST_CASE("what cannot be filmed is refused in a sentence that names the flag and what it takes", "[film]") {
  CHECK(refusal({.time = "9.5"}) == "--time 9.5 is outside the recording, which spans 0 to 2 s");
  CHECK_THAT(refusal({.time = "0.5..3"}), Contains("--time 3 is outside"));
  CHECK_THAT(refusal({.time = "-1"}), Contains("--time -1 is outside"));
  CHECK_THAT(refusal({.time = "noon"}), Contains("not 'noon'"));
  CHECK_THAT(refusal({.time = "1..0.5"}), Contains("ends before it begins"));
  CHECK_THAT(refusal({.size = "640"}), Contains("--size takes WIDTHxHEIGHT"));
  CHECK_THAT(refusal({.size = "4x4"}), Contains("not '4x4'"));
  CHECK_THAT(refusal({.exposure = "bright"}), Contains("--exposure takes a time"));
  CHECK_THAT(refusal({.stereo = "0"}), Contains("above 0"));
  CHECK_THAT(refusal({.view = "0,0,0", .path = "x.csv"}), Contains("give one of them"));
  CHECK_THAT(refusal({.speed = 0.001, .framerate_hz = 1000}), Contains("raise --speed"));
  const std::string path = sample::scratch_folder("film_long_path") + "/p.csv";
  std::ofstream(path) << "time_s,dx\n0,0\n200000,1\n";
  CHECK_THAT(refusal({.path = path, .time = "0.5"}), Contains("let the path of the view end earlier"));
}

TEST_CASE("a length in metres needs a recording that has poses, and a view needs the field", "[film]") {
  FilmedRecording posed = kWalk;
  posed.has_poses = true;
  Settings::Fit tracked, given, fixed, blind, state_alone;
  tracked.knobs["pose"] = "tracked", given.knobs["pose"] = "given", fixed.knobs["pose"] = "fixed";
  blind.knobs["field"] = "none", state_alone.emit = EmitLayer::State;
  CHECK(planned({.stereo = "63mm"}, posed).value().baseline == Approx(0.063));
  CHECK_THAT(refusal({.stereo = "63mm"}), Contains("--stereo is in metres, but the poses are tracked"));
  CHECK_THAT(refusal({.stereo = "63mm"}, posed, tracked), Contains("--stereo is in metres"));
  CHECK(planned({.stereo = "63mm"}, posed, given).ok());
  for (const FilmedRecording& recording : {kWalk, posed})
    CHECK_THAT(refusal({.view = "63mm,0,0"}, recording, fixed),
               Contains("--view is in metres") && Contains("leave out --set pose=fixed"));
  CHECK_THAT(refusal({.view = "0.1,0,0"}, kWalk, blind), Contains("--set field=none"));
  CHECK(planned({}, kWalk, blind).ok());
  CHECK_THAT(refusal({.view = "0.1,0,0"}, kWalk, state_alone), Contains("leave out --emit state"));
  CHECK_THAT(refusal({.stereo = "0.02"}, kWalk, state_alone), Contains("leave out --emit state"));
  CHECK(planned({}, kWalk, state_alone).ok());
}
