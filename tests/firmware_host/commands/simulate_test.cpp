// The verb `simulate` as a user meets it: a recording that reads, a clip that is scored, a plan that is
// explained.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "firmware_host/exit_code.h"
#include "hal/fault/faulty_storage.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/recording.h"
#include "render/scores/scores.h"
#include "tests/contracts/expect.h"
#include "tests/firmware_host/commands/verb_runs.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/ran_here.h"

#include "tests/support/ran.h"

using namespace hdrcam;
using test::Ran;

namespace {

Ran run_simulate(const std::string& arguments) { return test::ran("simulate " + arguments); }

void require_success(const std::string& arguments) {
  const Ran run = run_simulate(arguments);
  INFO(run.output);
  REQUIRE(run.exit_code == 0);
}

}  // namespace

TEST_CASE("simulate writes a recording with the exposures of its cycle") {
  const std::string path = sample::scratch_folder("simulate_recording") + "/walk.mkv";
  require_success(fmt::format("'walk?size=64x48' -o {} --frames 7 --shutter 1ms,8ms --gain 1,2", path));
  auto reader = value_of(open_recording(posix_storage(), path));
  CHECK(reader->camera().name == "walk");
  CHECK(reader->camera().width == 64);
  for (int i = 0; i < 7; ++i) {
    const auto frame = value_of(reader->next());
    REQUIRE(frame);
    CHECK(frame->facts.exposure() == Approx(i % 2 == 0 ? 0.001 : 0.016));
    CHECK(frame->facts.slot == i % 2);
    CHECK(frame->facts.timestamp.seconds() == Approx(i / 30.0));
  }
  CHECK_FALSE(value_of(reader->next()));
}

TEST_CASE("a rolling shutter's recording states its read-out time, and a replay takes the skew out") {
  const std::string folder = sample::scratch_folder("simulate_rolling"), path = folder + "/fast.mkv",
                    truth = folder + "/truth";
  require_success(fmt::format("'fast?size=128x96&seed=2' -o {} --truth {} --frames 12", path, truth));
  auto reader = value_of(open_recording(posix_storage(), path));
  CHECK(value_of(reader->next())->facts.readout_s == Approx(0.012));
  const auto psnr_mu_db = [&](const std::string& readout) {
    const std::string frames = folder + "/readout" + readout;
    REQUIRE(test::ran(fmt::format("replay {} -o {}/%06d.exr --preset realtime {}", path, frames,
                                  readout.empty() ? "" : "--readout " + readout))
                .exit_code == 0);
    return value_of(score_clip(posix_storage(), truth, frames, {})).mean.psnr_mu_db;
  };
  const double corrected = psnr_mu_db("");
  CHECK(corrected > psnr_mu_db("off") + 1);
  CHECK(corrected == psnr_mu_db("12ms"));
}

TEST_CASE("the same command writes the same bytes") {
  const std::string folder = sample::scratch_folder("simulate_same");
  for (const int threads : {1, 2})
    require_success(fmt::format("'night?size=64x48&seed=5' -o {}/{}.mkv --frames 5 --threads {}", folder,
                                threads, threads));
  const auto bytes = [&](int threads) {
    return value_of(read_whole(posix_storage(), fmt::format("{}/{}.mkv", folder, threads)));
  };
  CHECK(bytes(1) == bytes(2));
}

TEST_CASE("a clip with truth is one that compare reads, and its truth is perfect") {
  const std::string folder = sample::scratch_folder("simulate_truth");
  require_success(fmt::format("'walk?size=64x48' --truth {}/clip --frames 6", folder));
  const ClipScores scores =
      value_of(score_clip(posix_storage(), folder + "/clip", folder + "/clip/gt/hdr", {0, nullptr}));
  CHECK(scores.frames.size() == 6);
  CHECK(scores.mean.psnr_mu_db > 100);
  REQUIRE(scores.flicker_stops);
  CHECK(*scores.flicker_stops < 1e-6);
  CHECK(scores.mean.psnr_mu_moving_db.has_value());
  CHECK(value_of(ImageSequence::open(posix_storage(), folder + "/clip")).frame_count() == 6);
}

TEST_CASE("a clip with truth says which frames of an earlier, longer one remain beside its own") {
  const std::string folder = sample::scratch_folder("simulate_older");
  const auto simulated = [&](int frames) {
    const Ran run =
        run_simulate(fmt::format("'still?size=32x24' --truth {} --frames {} --force", folder, frames));
    INFO(run.output);
    CHECK(run.exit_code == 0);
    return run.output;
  };
  CHECK_THAT(simulated(4), !Catch::Contains("earlier run"));
  const std::string shorter = simulated(2);
  for (const char* frames : {"/ldr/%04d.png", "/gt/hdr/%04d.exr", "/gt/depth/%04d.exr"})
    CHECK_THAT(shorter, Catch::Contains("before '" + folder + frames + "' is read as one clip"));
  CHECK_THAT(shorter, Catch::Contains("warning: 2 files of an earlier run remain beside the new ones"));
  CHECK_THAT(simulated(4), !Catch::Contains("earlier run"));
}

TEST_CASE("the truth names what pictures have and the true radiance leaves out") {
  const std::string folder = sample::scratch_folder("simulate_left_out");
  const auto left_out = [&](const std::string& scene) {
    require_success(fmt::format("'{}' --truth {} --frames 1 --force", scene, folder));
    return test::json_in(folder + "/gt/gt.json")["radiance_leaves_out"].get<std::vector<std::string>>();
  };
  using Names = std::vector<std::string>;
  CHECK(left_out("night?size=32x24") ==
        Names{"motion-blur", "flare", "mains-flicker", "hot-pixels", "noise"});
  CHECK(left_out("pan?size=32x24&without=noise") == Names{"motion-blur", "rolling-shutter"});
  CHECK(left_out("still?size=32x24&without=noise").empty());
}

TEST_CASE("dropped frames are gaps in the recording, flagged behind the gap") {
  const std::string path = sample::scratch_folder("simulate_drops") + "/d.mkv";
  require_success(fmt::format("'still?size=32x32&drops=0.4' -o {} --frames 20", path));
  auto reader = value_of(open_recording(posix_storage(), path));
  std::uint64_t before = 0;
  int gaps = 0;
  for (int i = 0; i < 20; ++i) {
    const auto frame = value_of(reader->next());
    REQUIRE(frame);
    const bool gap = i > 0 && frame->facts.sequence != before + 1;
    CHECK(((frame->facts.flags & kFrameAfterDrop) != 0) == gap);
    gaps += gap, before = frame->facts.sequence;
  }
  CHECK(gaps > 2);
}

TEST_CASE("a scene that loses every frame is refused, and nothing is written") {
  const std::string path = sample::scratch_folder("simulate_all_lost") + "/d.mkv";
  const Ran run = run_simulate(fmt::format("'walk?size=64x48&drops=1' -o {} --frames 3", path));
  INFO(run.output);
  CHECK(run.exit_code == exit_code_of(ErrorCode::Invalid));
  CHECK(run.output.find("drops=1") != std::string::npos);
  CHECK_FALSE(posix_storage().open(path).ok());
}

TEST_CASE("explain names every effect, its reason, and a cost where it is on") {
  const Ran run = run_simulate("'night?size=64x48' --explain");
  INFO(run.output);
  REQUIRE(run.exit_code == 0);
  for (const char* words :
       {"motion-blur", "clock-jitter", "street lamps on 50 Hz mains", "the scene does not need it", "CPU ms"})
    CHECK(run.output.find(words) != std::string::npos);
}

TEST_CASE("a raw recording is Bayer, linear and explained as such") {
  const std::string path = sample::scratch_folder("simulate_raw") + "/r.mkv";
  require_success(
      fmt::format("'still?size=32x32&black=0.0625' -o {} --frames 2 --format bayer --bits 12", path));
  auto reader = value_of(open_recording(posix_storage(), path));
  CHECK(reader->camera().layout == PixelLayout::BayerRggb);
  CHECK(reader->camera().bits == 12);
  CHECK(reader->camera().linear);
  CHECK(value_of(reader->next())->facts.black_level->code(12) == Approx(0.0625 * 4095));
}

TEST_CASE("a clip with truth is replaced with --force only, and no recording takes the place of its files") {
  const std::string folder = sample::scratch_folder("simulate_kept"), clip = folder + "/clip";
  const auto frames = [&] { return value_of(ImageSequence::open(posix_storage(), clip)).frame_count(); };
  require_success(fmt::format("'walk?size=32x32' --truth {} --frames 4", clip));
  const Ran again = run_simulate(fmt::format("'walk?size=32x32' --truth {} --frames 2", clip));
  CHECK(again.exit_code == 17);
  CHECK(again.output.find("--force") != std::string::npos);
  CHECK(frames() == 4);
  require_success(fmt::format("'walk?size=32x32' --truth {} --frames 2 --force", clip));
  CHECK(frames() == 2);
  for (const char* file : {"clip.json", "gt/gt.json", "ldr/0000.png"}) {
    INFO(file);
    const Ran mixed = run_simulate(
        fmt::format("'walk?size=32x32' --truth {0}/new -o {0}/new/{1} --frames 2", folder, file));
    CHECK(mixed.exit_code == 2);
    CHECK(mixed.output.find("is not the name of a recording") != std::string::npos);
  }
  CHECK_FALSE(std::filesystem::exists(folder + "/new"));
}

TEST_CASE("a simulation that is stopped leaves a whole recording and a whole clip of the frames before") {
  const std::string folder = sample::scratch_folder("simulate_stopped"), path = folder + "/walk.mkv",
                    clip = folder + "/clip";
  std::atomic<bool> stop{false};
  std::thread user([&] {
    while (!stop && !std::filesystem::exists(clip + "/gt/id/0002.png"))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stop = true;
  });
  const test::RanHere run =
      test::ran_here({"simulate", "walk?size=32x32", "--frames", "100000", "-o", path, "--truth", clip},
                     posix_storage(), stop);
  stop = true;
  user.join();
  INFO(run.err);
  CHECK(run.exit_code == kExitInterrupted);
  const auto recorded = sample::replay(posix_storage(), path);
  CHECK(!recorded.error);
  CHECK(recorded.frames.size() >= 3);
  CHECK(value_of(ImageSequence::open(posix_storage(), clip)).frame_count() ==
        static_cast<int>(recorded.frames.size()));
  CHECK(value_of(score_clip(posix_storage(), clip, clip + "/gt/hdr", {.skip = 0})).frames.size() ==
        recorded.frames.size());
}

TEST_CASE("a recording that a full disk cuts is said to be so, with how many frames it has") {
  const std::string path = sample::scratch_folder("simulate_full") + "/walk.mkv";
  FaultyStorage full(posix_storage(), {.space_bytes = 40'000});
  const test::RanHere run =
      test::ran_here({"simulate", "walk?size=64x48", "-o", path, "--frames", "60"}, full);
  const std::size_t frames = sample::replay(posix_storage(), path).frames.size();
  CAPTURE(run.err, frames);
  CHECK(run.exit_code == exit_code_of(ErrorCode::NoSpace));
  CHECK(frames >= 2);
  CHECK(run.err.find(fmt::format("'{0}' is cut after {1} frames, of which 'hdrcam repair {0} -o FILE'", path,
                                 frames)) != std::string::npos);
}

TEST_CASE("simulate refuses in a sentence what it cannot do") {
  CHECK(run_simulate("walk").output.find("--truth") != std::string::npos);
  CHECK(run_simulate("").output.find("--list") != std::string::npos);
  const std::string folder = sample::scratch_folder("simulate_refused"), walk = folder + "/walk.mkv";
  const Ran too_long = run_simulate("walk -o " + walk + " --shutter 50ms");
  CHECK(too_long.output.find("does not fit") != std::string::npos);
  const Ran equal = run_simulate("walk -o " + walk + " --shutter 4ms,4ms,4ms");
  CHECK(equal.exit_code == kExitUsage);
  CHECK(equal.output.find("all 3 exposures of the cycle are the same, 4 ms") != std::string::npos);
  const Ran too_many = run_simulate("walk -o " + walk + " --shutter 1ms,2ms,4ms,8ms,16ms");
  CHECK(too_many.exit_code == kExitUsage);
  CHECK(too_many.output.find("a cycle has 1 to 4 exposures, not 5") != std::string::npos);
  CHECK(run_simulate("--list -o " + walk).exit_code == kExitUsage);
  CHECK(run_simulate("nowhere --explain").exit_code == exit_code_of(ErrorCode::NotFound));
  CHECK(run_simulate("--list").output.find("a street against the sun") != std::string::npos);
  CHECK(std::filesystem::is_empty(folder));
}

TEST_CASE("the list of scenes heeds --config and --print-config") {
  const std::string settings = run_simulate("--list --print-config").output;
  CHECK(settings.find("[schedule]") != std::string::npos);
  CHECK(settings.find("a street against the sun") == std::string::npos);
  CHECK(run_simulate("--list --config nosuch.toml").exit_code == exit_code_of(ErrorCode::NotFound));
}

TEST_CASE("a simulation that is stopped before its first frame says so and leaves nothing") {
  const std::string folder = sample::scratch_folder("simulate_stopped_at_once");
  const test::RanHere run = test::ran_here(
      {"simulate", "still?size=32x32", "-o", folder + "/out/walk.mkv", "--truth", folder + "/clip"},
      posix_storage(), true);
  CHECK(run.exit_code == kExitInterrupted);
  CHECK(run.err.find("stopped before the first frame") != std::string::npos);
  CHECK(std::filesystem::is_empty(folder));
}
