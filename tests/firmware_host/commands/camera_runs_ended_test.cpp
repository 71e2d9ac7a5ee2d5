// Runs of a camera that end by a signal: ^C, which finishes what was written, and a kill at any moment.
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <map>
#include <random>
#include <thread>

#include "firmware_host/commands/run_limits.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/firmware_host/commands/verb_runs.h"
#include "tests/support/becomes_true.h"
#include "tests/support/process.h"
#include "tests/support/ran.h"

using namespace hdrcam;
using test::becomes_true;
using test::files_in;
using test::frames_in;
using test::ran_here;
using test::RanHere;
using test::require_success;
using test::started;

namespace {

bool has_size(const std::string& path, std::uintmax_t bytes) {
  std::error_code missing;
  const std::uintmax_t size = std::filesystem::file_size(path, missing);
  return !missing && size >= bytes;
}

// A killed recorder must leave a recording that reads up to its last frames, every one with its own exposure.
// Which exposure a frame has shows in its picture: the scene stands still and makes no noise.
void survives_kills(int kills) {
  const std::string path = sample::scratch_folder("killed") + "/raw.mkv";
  const std::string camera = "sim:still?size=64x48&fps=200&without=noise";
  const auto key_of = [](const RawFrame& frame) {
    double sum = 0;
    for (const std::uint16_t code : frame.codes.samples()) sum += code;
    return sum / static_cast<double>(frame.codes.size());
  };
  std::map<std::int64_t, double> brightness;  // by exposure, us
  require_success({"record", "--camera", camera, "--format", "RGB24", "--shutter", "1ms,2ms,4ms", "--frames",
                   "40", "-o", path});
  const auto label_of = [](const RawFrame& frame) { return std::llround(frame.facts.exposure_s * 1e6); };
  for (const RawFrame& frame : frames_in(path)) brightness[label_of(frame)] = key_of(frame);
  REQUIRE(brightness.size() == 3);

  std::mt19937 random(20);
  std::uniform_int_distribution<int> when_ms(0, 600);
  std::size_t read = 0;
  for (int i = 0; i < kills; ++i) {
    std::filesystem::remove(path);
    const pid_t process =
        started({"record", "--camera", camera, "--format", "RGB24", "--shutter", "1ms,2ms,4ms", "-o", path});
    if (i % 3 != 0)  // others are killed as early as it comes
      CHECK(becomes_true([&] { return has_size(path, 64 << 10); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(when_ms(random)));
    kill(process, SIGKILL);
    int status = 0;
    REQUIRE(waitpid(process, &status, 0) == process);
    REQUIRE(WIFSIGNALED(status));
    auto opened = open_recording(posix_storage(), path);
    if (!opened) {  // killed before the first frame was whole
      const ErrorCode code = opened.error().code;
      CHECK((code == ErrorCode::NotFound || code == ErrorCode::Truncated || code == ErrorCode::NotRecording));
      continue;
    }
    for (const RawFrame& frame : frames_in(path)) {
      ++read;
      const auto known = brightness.find(label_of(frame));
      REQUIRE(known != brightness.end());
      CHECK(key_of(frame) == Approx(known->second).epsilon(1e-6));
    }
  }
  CHECK(read > static_cast<std::size_t>(10 * kills));
}

}  // namespace

TEST_CASE("^C is how a run without limits ends well; one that was to go on says that it was stopped") {
  for (const bool limited : {false, true}) {
    const std::string folder = sample::scratch_folder(limited ? "live_cut_short" : "live_ended");
    std::vector<std::string> words{"live",
                                   "--shutter",
                                   "1ms,4ms",
                                   "--camera",
                                   "sim:still?size=64x48&fps=60",
                                   "--format",
                                   "RGB24",
                                   "--preset",
                                   "fast",
                                   "--emit",
                                   "state",
                                   "-o",
                                   folder + "/%06d.exr",
                                   "--record",
                                   folder + "/raw.mkv"};
    if (limited) words.insert(words.end(), {"--frames", "100000"});
    const pid_t process = started(words);
    CHECK(becomes_true([&] { return files_in(folder, ".exr") >= 5; }));
    kill(process, SIGINT);
    int status = 0;
    REQUIRE(waitpid(process, &status, 0) == process);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == (limited ? kExitInterrupted : kExitOk));
    auto reader = value_of(open_recording(posix_storage(), folder + "/raw.mkv"));
    REQUIRE(reader->frame_count());  // the index is there: the recording was finished
    CHECK(static_cast<std::size_t>(*reader->frame_count()) >= files_in(folder, ".exr"));
  }
}

TEST_CASE("^C before there are frames enough for an HDR frame is no failure either, but cuts limits short") {
  for (const bool limited : {false, true}) {
    const std::string folder =
        sample::scratch_folder(limited ? "live_cut_short_at_once" : "live_stopped_at_once");
    const std::string raw = folder + "/raw.mkv";
    std::vector<std::string> words{"live",
                                   "--camera",
                                   "sim:still?size=64x48&fps=2",
                                   "--shutter",
                                   "1ms,4ms",
                                   "--format",
                                   "RGB24",
                                   "--preset",
                                   "fast",
                                   "-o",
                                   folder + "/%06d.exr",
                                   "--record",
                                   raw};
    if (limited) words.insert(words.end(), {"--frames", "100000"});
    const pid_t process = started(words);
    CHECK(becomes_true([&] { return std::filesystem::exists(raw); }));
    kill(process, SIGINT);  // one frame is there; two are the least
    int status = 0;
    REQUIRE(waitpid(process, &status, 0) == process);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == (limited ? kExitInterrupted : kExitOk));
    CHECK(value_of(open_recording(posix_storage(), raw))->frame_count());
  }
}

TEST_CASE("a run without an HDR frame tells no latency") {
  const test::Ran run = test::ran({"live", "--camera", "sim:still?size=64x48", "--frames", "1"});
  INFO(run.output);
  CHECK(run.exit_code == exit_code_of(ErrorCode::TooShort));
  CHECK_THAT(run.output, Catch::Contains("captured 1 = emitted 0") && !Catch::Contains("latency: "));
}

TEST_CASE("a time limit before the first frame is a failure that a script can see") {
  const std::string folder = sample::scratch_folder("record_too_short"), copy = folder + "/copy.mkv";
  const RanHere run = ran_here({"record", "--camera", "replay:" HDRCAM_SOURCE_DIR "/tests/data/demo.mkv",
                                "--timeout", "1e-9", "-o", copy});
  CHECK(run.exit_code == exit_code_of(ErrorCode::Timeout));
  CHECK_THAT(run.err, Catch::Contains("no frame came within --timeout"));
  CHECK_FALSE(std::filesystem::exists(copy));
  for (const char* camera : {"replay:" HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", "sim:still?size=64x48"}) {
    const RanHere fitted = ran_here({"live", "--camera", camera, "--timeout", "1e-9"});
    INFO(fitted.err);
    CHECK(fitted.exit_code == exit_code_of(ErrorCode::Timeout));
    CHECK_THAT(fitted.err, Catch::Contains("no frame came within --timeout"));
  }
  const RunLimits limits{.timeout_s = 1};
  require_error(limits.ended_by(LiveEnd::Timeout, 0), ErrorCode::Timeout);
  CHECK(limits.ended_by(LiveEnd::Timeout, 1).ok());
}

TEST_CASE("a recording without frames in place of a camera ends before its time limit, and is not late") {
  const std::string folder = sample::scratch_folder("record_of_nothing"), empty = folder + "/empty.mkv";
  const auto writer = create_recording(posix_storage(), empty, sample::camera(PixelLayout::Rgb, 8, 64, 48));
  REQUIRE(writer.ok());
  require_done(writer.value()->finish());
  const test::Ran run =
      test::ran({"record", "--camera", "replay:" + empty, "--timeout", "3600", "-o", folder + "/copy.mkv"});
  CHECK(run.exit_code == kExitOk);
  CHECK_THAT(run.output, Catch::Contains("0 frames"));
  CHECK(run.output.find("--timeout") == std::string::npos);
}

TEST_CASE("a recorder that is killed leaves a readable recording, each frame with its own exposure") {
  survives_kills(12);
}

TEST_CASE("a recorder that is killed at a thousand moments leaves a readable recording each time",
          "[.][full]") {
  survives_kills(1000);
}
