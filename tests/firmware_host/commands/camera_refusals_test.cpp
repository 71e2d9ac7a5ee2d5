// What the verbs that run a camera refuse before it starts, as a user meets it: what cannot be, and flags
// that the run would ignore.
#include <filesystem>
#include <span>

#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"

#include "tests/firmware_host/commands/verb_runs.h"
#include "tests/support/files.h"
#include "tests/support/ran.h"

using namespace hdrcam;
using test::check_refused;
using test::json_in;
using test::require_success;

TEST_CASE("a camera replay: without a file is refused with what belongs there, by every verb of a camera") {
  const std::string folder = sample::scratch_folder("replay_nothing");
  for (const std::vector<std::string>& verb : {std::vector<std::string>{"live", "-o", folder + "/%06d.exr"},
                                               {"record", "-o", folder + "/x.mkv"},
                                               {"record", "-o", folder + "/x.mkv", "--pace", "realtime"},
                                               {"calibrate", "delay"}}) {
    std::vector<std::string> words = verb;
    words.insert(words.end(), {"--camera", "replay:"});
    check_refused(words, ErrorCode::Invalid, "'replay:' names no recording; write --camera replay:walk.mkv");
  }
}

TEST_CASE(
    "a flag that a recorded camera would ignore is refused, and a file of settings that holds it is not") {
  const std::string folder = sample::scratch_folder("ignored_flags"), walk = folder + "/walk.mkv";
  require_success({"simulate", "walk?size=64x48", "--frames", "4", "-o", walk});
  const std::vector<std::string> copy{"record", "--camera", "replay:" + walk, "-o", folder + "/copy.mkv"};
  const auto with = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), copy.begin(), copy.end());
    return flags;
  };
  check_refused(with({"--width", "128", "--height", "96", "--shutter", "9ms"}), ErrorCode::Invalid,
                "leave out --width, --height, --shutter");
  for (const auto& [flag, value] : {std::pair("--framerate", "5"),
                                    {"--gain", "4"},
                                    {"--format", "YUYV"},
                                    {"--control-delay", "2,1"},
                                    {"--timestamp", "end"},
                                    {"--adapt", "light"},
                                    {"--mains", "50"}})
    for (const char* pace : {"fit", "realtime"})
      check_refused(with({"--pace", pace, flag, value}), ErrorCode::Invalid,
                    std::string("are recorded and cannot be set; leave out ") + flag);
  check_refused({"live", "--camera", "replay:" + walk, "--adapt", "motion"}, ErrorCode::Invalid, "--adapt");
  for (const auto& [flag, value] : {std::pair("--buffers", "6"),
                                    {"--yuv-range", "full"},
                                    {"--sync-line", "gpiochip0:17"},
                                    {"--strobe", "exposure"},
                                    {"--record-memory", "64"}})
    check_refused(with({flag, value}), ErrorCode::Invalid,
                  std::string("give --pace realtime to play it as a camera, or leave out ") + flag);
  check_refused(
      {"live", "--camera", "replay:" + walk, "--http", "127.0.0.1:0", "--http-record", folder + "/%03d.mkv"},
      ErrorCode::Invalid, "leave out --http-record");
  CHECK_FALSE(std::filesystem::exists(folder + "/copy.mkv"));

  require_success(with({"--sync-active-low=false", "--trigger-active-low=false"}));
  const std::string file = folder + "/rig.toml",
                    text = "[camera]\nwidth = 128\n[schedule]\nadapt = \"light\"\n";
  REQUIRE(write_whole(posix_storage(), file, std::as_bytes(std::span(text))).ok());
  require_success(with({"--config", file, "--force"}));
}

TEST_CASE("what is asked of a recording is refused of a camera, also of one that a recording plays") {
  const std::string walk = sample::scratch_folder("ignored_pace") + "/walk.mkv";
  require_success({"simulate", "walk?size=64x48", "--frames", "4", "-o", walk});
  check_refused({"live", "--camera", "sim:still", "--pace", "realtime"}, ErrorCode::Invalid,
                "give --camera replay:FILE, or leave out --pace");
  check_refused({"live", "--camera", "sim:still", "--strict"}, ErrorCode::Invalid,
                "--strict is for a recording");
  check_refused({"live", "--camera", "replay:" + walk, "--pace", "realtime", "--strict"}, ErrorCode::Invalid,
                "not with --pace realtime");
}

TEST_CASE("a run on a recording that is refused before its first frame has no account of frames") {
  const std::string folder = sample::scratch_folder("no_account"), walk = folder + "/walk.mkv";
  require_success({"simulate", "walk?size=64x48", "--frames", "4", "-o", walk});
  const test::Ran refused =
      test::ran({"live", "--camera", "replay:" + walk, "--readout", "100s", "-o", folder + "/out/%06d.exr"});
  INFO(refused.output);
  CHECK(refused.exit_code == exit_code_of(ErrorCode::Invalid));
  CHECK(refused.output.find("--readout 100s is longer than a frame") != std::string::npos);
  CHECK(refused.output.find("0 proved") == std::string::npos);
}

TEST_CASE("a flag of an output that a run does not have is refused with the output to give") {
  const std::string folder = sample::scratch_folder("ignored_outputs"), walk = folder + "/walk.mkv";
  require_success({"simulate", "walk?size=64x48", "--frames", "4", "-o", walk});
  const auto unused = [&](const char* flag, const char* value, const char* why) {
    check_refused({"replay", walk, "--stats", folder + "/s.json", flag, value}, ErrorCode::Invalid, why);
  };
  unused("--layers", "depth", "give -o out/%06d.exr, or leave out --layers");
  unused("--compression", "zip", "give -o out/%06d.exr, or leave out --compression");
  unused("--crf", "20", "give -o out.mp4, or leave out --crf");
  unused("--white", "100", "give -o out.mp4, or leave out --white");
  unused("--transfer", "sdr", "give -o out.mp4, or leave out --transfer");
  unused("--pipe-format", "y4m", "give -o -, or leave out --pipe-format");
  check_refused({"render", walk, "--deadline", "33ms", "-o", folder + "/%06d.exr"}, ErrorCode::Invalid,
                "--deadline");
  const std::string page_alone =
      "this run has no live page; give --http 127.0.0.1:8080, or leave out --http-";
  unused("--http-token", "abc", page_alone.c_str());
  for (const auto& [flag, value] :
       {std::pair<std::string, std::string>("--http-token", "abc"), {"--http-record", folder + "/%03d.mkv"}})
    check_refused({"live", "--camera", "sim:still", flag, value}, ErrorCode::Invalid, page_alone);
  CHECK_FALSE(std::filesystem::exists(folder + "/s.json"));
}

TEST_CASE("a flag of a line or a recording that a run does not have is refused with the one to give") {
  const auto alone = [&](const char* flag, const char* value, const char* without) {
    check_refused({"live", "--camera", "sim:still", flag, value}, ErrorCode::Invalid,
                  fmt::format("give {}, or leave out {}", without, flag));
  };
  alone("--strobe", "exposure", "--sync-line gpiochip0:17");
  alone("--strobe-delay", "1ms", "--sync-line gpiochip0:17");
  alone("--trigger-gap", "2ms", "--trigger-line gpiochip0:17");
  check_refused({"live", "--camera", "sim:still", "--sync-active-low"}, ErrorCode::Invalid,
                "give --sync-line gpiochip0:17, or leave out --sync-active-low");
  alone("--record-codec", "ffv1", "--record walk.mkv");
  check_refused({"record", "--camera", "sim:still", "--record-codec", "ffv1"}, ErrorCode::Invalid,
                "no output file; give -o FILE");
}

TEST_CASE("white, peak and transfer are refused where no output has them") {
  const std::string folder = sample::scratch_folder("ignored_light"), walk = folder + "/walk.mkv";
  require_success({"simulate", "walk?size=64x48", "--frames", "6", "-o", walk});
  const auto with = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"replay", walk, "--preset", "fast", "--emit", "state"});
    return flags;
  };
  for (const char* flag : {"--white", "--peak"}) {
    check_refused(with({"-o", "-", "--pipe-format", "half", flag, "400"}), ErrorCode::Invalid,
                  std::string("writes no video; give -o out.mp4, or leave out ") + flag);
    check_refused(with({"-o", folder + "/x.mp4", "--transfer", "sdr", flag, "400"}), ErrorCode::Invalid,
                  std::string("give --transfer pq or hlg, or leave out ") + flag);
  }
  const std::string no_transfer = "writes no video; give -o out.mp4, or leave out --transfer";
  check_refused(with({"-o", "-", "--pipe-format", "half", "--transfer", "hlg"}), ErrorCode::Invalid,
                no_transfer);
  check_refused(with({"--http", "127.0.0.1:0", "--transfer", "hlg"}), ErrorCode::Invalid, no_transfer);
  check_refused({"encode", folder + "/%06d.exr", "-o", "-", "--pipe-format", "half", "--peak", "400"},
                ErrorCode::Invalid, "leave out --peak");
  CHECK_FALSE(std::filesystem::exists(folder + "/x.mp4"));
  require_success(with({"--http", "127.0.0.1:0", "--white", "100"}));  // the page shows HDR pictures
  require_success(with({"-o", folder + "/y.mp4", "--transfer", "hlg", "--white", "100"}));

  const std::string file = folder + "/rig.toml", text = "[video]\nwhite = 2000\n";
  REQUIRE(write_whole(posix_storage(), file, std::as_bytes(std::span(text))).ok());
  require_success(with({"-o", folder + "/z.mp4", "--transfer", "sdr", "--config", file}));
}

TEST_CASE(
    "a misspelt {start} is refused before a camera is opened, also in recordings that the page starts") {
  const std::string folder = sample::scratch_folder("misspelt_start");
  const std::vector<std::string> live{"live", "--camera", "sim:nowhere", "--http", "127.0.0.1:0"};
  for (const auto& [flag, name] :
       {std::pair("--http-record", "/takes-{strat}/%03d.mkv"), {"--record", "/{strat}.mkv"}}) {
    std::vector<std::string> words = live;
    words.insert(words.end(), {flag, folder + name});
    check_refused(words, ErrorCode::Invalid, "has {strat} in its name, which stands for nothing");
  }
  CHECK(std::filesystem::is_empty(folder));
}

TEST_CASE("recordings that the live page starts are refused as a flag of a replay, and ignored in a file") {
  const std::string folder = sample::scratch_folder("ignored_takes"), walk = folder + "/walk.mkv",
                    file = folder + "/rig.toml", takes = folder + "/takes/%03d.mkv",
                    text = "[output]\nhttp_record = \"" + takes + "\"\n";
  require_success({"simulate", "walk?size=64x48", "--frames", "6", "-o", walk});
  REQUIRE(write_whole(posix_storage(), file, std::as_bytes(std::span(text))).ok());
  for (const std::string verb : {"replay", "render"}) {
    const std::string stats = folder + "/" + verb + ".json";
    std::vector<std::string> words{verb, walk, "--preset", "fast", "--emit", "state", "--stats", stats};
    const std::size_t size = words.size();
    words.insert(words.end(), {"--http-record", takes});
    check_refused(words, ErrorCode::Invalid, "unknown flag '--http-record' (a flag of live)");
    words.resize(size);
    words.insert(words.end(), {"--config", file});
    require_success(words);
    CHECK(json_in(stats)["command"].get<std::string>().find("--http-record") == std::string::npos);
  }
}

TEST_CASE(
    "a run that writes no files says so once its camera is there, and a refused one gives the reason alone") {
  const test::Ran refused = test::ran({"live", "--camera", "sim:nowhere"});
  CHECK(refused.exit_code == exit_code_of(ErrorCode::NotFound));
  CHECK_THAT(refused.output, Catch::StartsWith("hdrcam: there is no scene 'nowhere'"));
  for (const std::string& camera : {std::string("sim:still?size=64x48"),
                                    std::string("replay:" HDRCAM_SOURCE_DIR "/tests/data/demo.mkv")}) {
    const test::Ran run = test::ran({"live", "--camera", camera, "--frames", "6", "--preset", "realtime"});
    INFO(run.output);
    CHECK(run.exit_code == kExitOk);
    CHECK_THAT(run.output, Catch::Contains("note: this run writes no files"));
  }
}

TEST_CASE("a place where the live page can make no recordings is refused before the camera starts") {
  const std::string folder = sample::scratch_folder("takes_nowhere");
  test::write_file(folder + "/notes", "no folder");
  check_refused({"live", "--camera", "sim:still?size=64x48", "--frames", "1", "--http", "127.0.0.1:0",
                 "--http-record", folder + "/notes/%03d.mkv"},
                ErrorCode::Permission, "/notes' is a file, and a folder is needed in its place");
}

TEST_CASE("a cycle of equal exposures is refused") {
  check_refused({"live", "--camera", "sim:still", "--shutter", "1ms,1ms,1ms"}, ErrorCode::Invalid,
                "all 3 exposures of the cycle are the same");
}

TEST_CASE("what cannot be is said before the camera starts, each with its own exit code") {
  const std::string sim = "sim:still?size=64x48";
  check_refused({"live", "--camera", "sim:nosuch"}, ErrorCode::NotFound, "nosuch");
  check_refused({"live", "--camera", "replay:/nonexistent.mkv"}, ErrorCode::NotFound, "/nonexistent.mkv");
  const std::string demo = HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";
  check_refused({"live", "--camera", demo}, ErrorCode::Invalid,
                "is a file and not a camera; a recording is --camera replay:" + demo);
  const std::string copy = sample::scratch_folder("refused_copy") + "/copy.mkv";
  check_refused({"record", "--camera", "replay:" + demo, "--memory", "64", "-o", copy},
                ErrorCode::Unsupported, "a copy of frames of 320x240 needs about");
  CHECK_FALSE(std::filesystem::exists(copy));
  check_refused({"live", "--camera", "/dev/video99"}, ErrorCode::NotFound, "/dev/video99");
  check_refused({"live", "--camera", sim, "--format", "YUYV"}, ErrorCode::Unsupported, "YUYV");
  check_refused({"live", "--camera", sim, "--shutter", "1ms,200ms"}, ErrorCode::BadExposure, "200 ms");
  check_refused({"live", "--camera", sim, "--shutter", "1ms,4ms", "--gain", "1,99"}, ErrorCode::BadExposure,
                "99");
  check_refused({"live", "--camera", sim, "--shutter", "1ms,zwei"}, ErrorCode::Invalid, "zwei");
  check_refused({"live", "--camera", sim, "--control-delay", "2;1"}, ErrorCode::Invalid, "2;1");
  check_refused({"live", "--camera", "sim:nosuch", "--http", "127.0.0.1:0", "--http-token", "abcdefg"},
                ErrorCode::Invalid, "--http-token has 7 characters; give 8 or more");
  check_refused({"live", "--camera", sim, "--preset", "slow"}, ErrorCode::Invalid, "slow");
  check_refused({"record", "--camera", sim}, ErrorCode::Invalid, "-o");
  check_refused({"record", "--camera", sim, "-o", "-"}, ErrorCode::Invalid, "name it like walk.mkv");
  check_refused({"live", "--camera", sim, "--record", "x.mp4"}, ErrorCode::Invalid, "name it like walk.mkv");
  check_refused({"record", "--camera", sim, "-o", "/proc/nonexistent/x.mkv"}, ErrorCode::NotFound,
                "/proc/nonexistent");
  check_refused({"calibrate", "gain", "--camera", sim}, ErrorCode::Invalid, "'gain'");
  check_refused({"calibrate", "delay", "--camera", sim, "-o", "-"}, ErrorCode::Invalid,
                "--output - would write a file named '-'");
  check_refused({"live", "--camera", sim, "--frames", "1", "--trace", "-"}, ErrorCode::Invalid,
                "--trace - would write a file named '-'");
  check_refused({"calibrate", "delay", "--camera", sim, "--shutter", "4ms"}, ErrorCode::Invalid,
                "no two exposures of --shutter 4ms are a stop or more apart");
}
