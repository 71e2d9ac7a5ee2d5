// A run on a simulated camera whose frames are begun and exposed by the trigger line, in real time, through
// the settings of the program.
#include <atomic>
#include <cmath>

#include "firmware_host/exit_code.h"
#include "firmware_host/live/camera_source.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/ran.h"
#include "tests/support/ran_here.h"

using namespace hdrcam;
using Catch::Contains;

namespace {

Settings triggered(const char* mode) {
  Settings settings;
  settings.camera.id = "sim:still?size=64x48&fps=50";
  settings.camera.format = "RGB24";
  settings.schedule.shutter = "1ms,4ms,12ms";
  settings.sync.trigger_line = settings.sync.line = "sim";
  settings.sync.trigger =
      std::string_view(mode) == "fsync" ? TriggerMode::FrameStart : TriggerMode::PulseWidth;
  return settings;
}

double value(const std::vector<NamedValue>& values, std::string_view name) {
  for (const NamedValue& value : values)
    if (value.name == name) return value.value;
  FAIL("no value '" << name << "'");
  return 0;
}

// The sentence with which the program refuses to run.
std::string refused(std::vector<std::string> words, ErrorCode expected) {
  const test::RanHere ended = test::ran_here(words);
  INFO(ended.err);
  CHECK(ended.exit_code == exit_code_of(expected));
  CHECK_THAT(ended.err, Catch::Matches("hdrcam: [^\n]*\\.\n"));
  return ended.err;
}

}  // namespace

TEST_CASE(
    "a run on a triggered camera accounts for every pulse, and its labels are the widths of the pulses") {
  for (const char* mode : {"fsync", "pulse-width"}) {
    INFO(mode);
    const std::atomic<bool> stop{false};
    const auto source = value_of(CameraSource::open(triggered(mode), {.frames = 45}, posix_storage(), stop));
    require_done(source->start());
    int trusted = 0;
    for (;;) {
      const auto frame = source->next();
      REQUIRE(frame.ok());
      if (frame.value() == nullptr) break;
      const FrameFacts& facts = frame.value()->facts;
      if (facts.slot < 0 || (facts.flags & kFrameTriggerLate) != 0) continue;
      constexpr double kCycle_s[] = {1e-3, 4e-3, 12e-3}, kTolerance_s = 500e-6;
      CHECK(std::abs(facts.exposure_s - kCycle_s[facts.slot]) <= kTolerance_s);
      ++trusted;
    }
    RunRecord record;
    require_done(source->finish(record));
    const TriggerCounters& trigger = source->session().counters().camera.trigger;
    CHECK(trusted > 0);
    CHECK(trigger.pulses >= 45);
    CHECK(trigger.spurious == 0);
    CHECK(trigger.answered + trigger.unanswered + 2 >= trigger.pulses);  // the last ones are not settled
    CHECK(value(record.counters, "trigger.pulses") == static_cast<double>(trigger.pulses));
    CHECK(value(record.counters, "trigger.edge_us_p99") == Approx(to_seconds(trigger.edge_p99) * 1e6));
    REQUIRE(record.notes.size() == 2);
    CHECK_THAT(record.notes[1], Contains("trigger 'sim'") && Contains(" pulses, ") &&
                                    Contains(" answered, ") && !Contains("--timestamp"));
    const bool says = record.notes[1].find("not scheduled in real time") != std::string::npos;
    CHECK(says == (source->warnings().size() == 1));
  }
}

TEST_CASE("where frames do not come at the times of their pulses, the account says what to check") {
  Settings settings = triggered("pulse-width");
  settings.schedule.shutter =
      "6ms,9ms,12ms";  // a stamp of the begin, taken for that of the end, is far from it
  settings.camera.timestamp = StampMeaning::ExposureEnd;
  const std::atomic<bool> stop{false};
  const auto source = value_of(CameraSource::open(settings, {.frames = 45}, posix_storage(), stop));
  require_done(source->start());
  while (value_of(source->next()) != nullptr) {
  }
  RunRecord record;
  require_done(source->finish(record));
  REQUIRE(record.notes.size() == 2);
  CHECK_THAT(record.notes[1], Contains("of 45 frames do not fit the pulses: check --timestamp"));
  CHECK(value(record.counters, "camera.triggered") < 45);
}

TEST_CASE("record drives a simulated camera by its trigger line and ends with the account of the pulses") {
  const std::string file = sample::scratch_folder("triggered") + "/walk.mkv";
  const test::Ran ended = test::ran(std::vector<std::string>{
      "record", "--camera", "sim:walk?size=64x48&rays=1&fps=50", "--shutter", "1ms,4ms,12ms",
      "--trigger-line", "sim", "--trigger", "pulse-width", "--frames", "30", "-o", file});
  INFO(ended.output);
  REQUIRE(ended.exit_code == 0);
  CHECK_THAT(ended.output, Contains("captured 30 = recorded 30") &&
                               Contains("trigger 'sim' (pulse width): ") && !Contains("answered"));
}

TEST_CASE("lines that cannot be are refused with what to change") {
  const std::vector<std::string> live{"live", "--camera"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.begin(), live.begin(), live.end());
    return words;
  };
  CHECK_THAT(refused(with({"sim:walk", "--trigger-line", "sim"}), ErrorCode::Invalid),
             Contains("'sim' would not be driven") && Contains("--trigger fsync or pulse-width"));
  CHECK_THAT(refused(with({"sim:walk", "--trigger", "fsync"}), ErrorCode::Invalid),
             Contains("--trigger-line"));
  CHECK_THAT(
      refused(with({"sim:walk", "--trigger-line", "gpiochip0:3", "--trigger", "fsync"}), ErrorCode::Invalid),
      Contains("'sim:walk' is simulated") && Contains("'gpiochip0:3'") && Contains("--trigger-line sim"));
  CHECK_THAT(
      refused(with({"/dev/video77", "--trigger-line", "sim", "--trigger", "fsync"}), ErrorCode::Invalid),
      Contains("/dev/video77") && Contains("'hdrcam list'"));
  CHECK_THAT(refused(with({"/dev/video77", "--sync-line", "sim"}), ErrorCode::Invalid),
             Contains("--sync-line sim"));
  CHECK_THAT(refused(with({"/dev/video77", "--trigger-line", "gpiochip77:3", "--sync-line", "gpiochip77:3",
                           "--trigger", "fsync"}),
                     ErrorCode::Invalid),
             Contains("'gpiochip77:3'") && Contains("the same line"));
  const std::string replayed = "replay:" HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";
  for (const char* pace : {"fit", "realtime"})
    CHECK_THAT(
        refused(with({replayed, "--pace", pace, "--trigger-line", "gpiochip0:3", "--trigger", "pulse-width"}),
                ErrorCode::Unsupported),
        Contains(fmt::format("'{}' cannot be triggered", replayed)));
  CHECK_THAT(refused(with({"sim:walk", "--trigger-line", "sim", "--trigger", "pulse-width", "--framerate",
                           "30", "--shutter", "1ms,30ms", "--trigger-gap", "5ms"}),
                     ErrorCode::BadExposure),
             Contains("pulse of 30 ms") && Contains("--shutter") && Contains("--trigger-gap"));
  CHECK_THAT(
      refused(with({"sim:walk", "--trigger-line", "sim", "--trigger", "pulse-width", "--gain", "1,2,4"}),
              ErrorCode::Invalid),
      Contains("gains 1 and 2"));
  CHECK_THAT(
      refused(with({"sim:walk", "--trigger-line", "sim", "--trigger", "fsync", "--trigger-width", "wide"}),
              ErrorCode::Invalid),
      Contains("wide"));
  CHECK_THAT(refused(with({"sim:walk", "--trigger-line", "sim", "--trigger", "pulse-width", "--trigger-width",
                           "1ms"}),
                     ErrorCode::Invalid),
             Contains("a pulse is as wide as the exposure") && Contains("leave out --trigger-width"));
}
