// The verbs that run a camera, live, record and calibrate, as a user meets them, on simulated and replayed
// cameras.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <span>
#include <thread>

#include "firmware_host/exit_code.h"
#include "hal/recording/recording.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/process.h"
#include "tests/support/ran_here.h"

#include "tests/support/ran.h"

using namespace hdrcam;
using test::ran_here;
using test::RanHere;
using test::started;

namespace {

void require_success(const std::vector<std::string>& words) {
  const RanHere result = ran_here(words);
  INFO(result.err);
  REQUIRE(result.exit_code == kExitOk);
}

void check_refused(const std::vector<std::string>& words, ErrorCode code, const std::string& named) {
  const RanHere result = ran_here(words);
  INFO(result.err);
  CHECK(result.exit_code == exit_code_of(code));
  CHECK(result.err.find(named) != std::string::npos);
}

nlohmann::json json_in(const std::string& path) {
  return nlohmann::json::parse(value_of(read_whole(posix_storage(), path)));
}

std::vector<RawFrame> frames_in(const std::string& path) {
  auto reader = value_of(open_recording(posix_storage(), path));
  std::vector<RawFrame> frames;
  for (;;) {
    auto next = reader->next();
    if (!next) require_error(next, ErrorCode::Truncated);
    if (!next || !*next) return frames;
    frames.push_back(std::move(**next));
  }
}

std::size_t files_in(const std::string& folder, const std::string& ending) {
  std::size_t count = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder))
    count += file.path().string().ends_with(ending) ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("live leaves HDR frames, a recording and numbers that add up") {
  const std::string folder = sample::scratch_folder("live");
  require_success({"live", "--camera", "sim:still?size=64x48&fps=60", "--format", "RGB24", "--shutter",
                   "1ms,4ms", "--preset", "fast", "--emit", "state", "--frames", "40", "-o",
                   folder + "/%06d.exr", "--record", folder + "/raw.mkv", "--stats", folder + "/stats.json"});
  const auto stats = json_in(folder + "/stats.json");
  const auto& counters = stats["counters"];
  CHECK(counters["captured"] == 40);
  CHECK(counters["recorded"] == 40);
  CHECK(counters["emitted"].get<int>() + counters["dropped"].get<int>() == 40);
  CHECK(counters["camera.contradicted"] == 0);
  CHECK(stats["emitted"].get<std::size_t>() == files_in(folder, ".exr"));
  CHECK(files_in(folder, ".exr") > 0);
  for (const auto& frame : stats["per_frame"]) CHECK(frame["latency_ms"].get<double>() > 0);
  CHECK(frames_in(folder + "/raw.mkv").size() == 40);
}

TEST_CASE("a deadline that nothing can hold costs previews and HDR frames, never captured or recorded ones") {
  const std::string folder = sample::scratch_folder("live_late");
  const test::Ran ended =
      test::ran({"live", "--camera", "sim:still?size=64x48&fps=20", "--format", "RGB24", "--shutter",
                 "1ms,4ms", "--deadline", "1us", "--frames", "60", "-o", folder + "/%06d.exr", "--preview",
                 folder + "/%06d.png", "--record", folder + "/raw.mkv", "--stats", folder + "/stats.json"});
  INFO(ended.output);
  REQUIRE(ended.exit_code == kExitOk);
  for (const std::string& advice :
       {std::string("give --preset realtime, a smaller --width and --height, or --deadline off"),
        "all frames are recorded: hdrcam replay " + folder + "/raw.mkv",
        "warning: '" + folder + "/%06d.png' got no frame: "})
    CHECK(ended.output.find(advice) != std::string::npos);
  const auto stats = json_in(folder + "/stats.json");
  const auto& counters = stats["counters"];
  CHECK(counters["captured"] == 60);
  CHECK(counters["recorded"] == 60);
  CHECK(counters["dropped.no_room"] == 0);
  CHECK(counters["dropped.deadline"].get<int>() > 0);
  CHECK(counters["dropped.deadline"] == stats["deadline"]["left_out"]);
  CHECK(counters["emitted"].get<int>() + counters["dropped"].get<int>() == 60);
  CHECK(stats["emitted"].get<std::size_t>() == files_in(folder, ".exr"));
  CHECK(files_in(folder, ".png") == 0);
  CHECK(stats["sinks"]["preview"]["left_out"] == stats["emitted"]);
  const auto& cheapest = stats["deadline"]["rungs"].back();
  CHECK(cheapest["name"] == "1 frame in 2");
  CHECK(cheapest["frames"].get<int>() >= 8);  // then it is given up
  CHECK(frames_in(folder + "/raw.mkv").size() == 60);
}

TEST_CASE(
    "a recording played as a camera gives the bytes of its replay, whatever it knows of lens and poses") {
  const std::string folder = sample::scratch_folder("live_same");
  require_success(
      {"simulate", "walk?size=64x48", "--shutter", "1ms,4ms", "--frames", "12", "--truth", folder + "/clip"});
  require_success({"import", folder + "/clip", "-o", folder + "/walk.mkv"});
  const std::vector<std::string> fit{"--preset", "fast", "--layers", "depth,flow,confidence,provenance"};
  std::vector<std::string> replay{"replay", folder + "/walk.mkv", "-o", folder + "/replay/%06d.exr"};
  std::vector<std::string> live{
      "live",     "--camera",          "replay:" + folder + "/walk.mkv", "-o", folder + "/live/%06d.exr",
      "--record", folder + "/copy.mkv"};
  for (auto* words : {&replay, &live}) words->insert(words->end(), fit.begin(), fit.end());
  require_success(replay);
  require_success(live);
  REQUIRE(files_in(folder + "/replay", ".exr") == 12);
  REQUIRE(files_in(folder + "/live", ".exr") == 12);
  for (int i = 0; i < 12; ++i) {
    const std::string name = fmt::format("/{:06}.exr", i);
    CAPTURE(name);
    CHECK(value_of(read_whole(posix_storage(), folder + "/replay" + name)) ==
          value_of(read_whole(posix_storage(), folder + "/live" + name)));
  }
  const auto original = frames_in(folder + "/walk.mkv"), copy = frames_in(folder + "/copy.mkv");
  REQUIRE(copy.size() == original.size());
  for (std::size_t i = 0; i < copy.size(); ++i) CHECK(sample::same(copy[i], original[i]));
}

TEST_CASE("a recording recorded again is the same one, and does not take as long as it lasts") {
  const std::string folder = sample::scratch_folder("record_again");
  require_success({"simulate", "walk?size=64x48&fps=1", "--shutter", "1ms,4ms", "--frames", "40", "--truth",
                   folder + "/clip"});
  require_success({"import", folder + "/clip", "-o", folder + "/walk.mkv"});
  const auto begin = std::chrono::steady_clock::now();
  require_success({"record", "--camera", "replay:" + folder + "/walk.mkv", "-o", folder + "/copy.mkv"});
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(20));
  const auto original = frames_in(folder + "/walk.mkv"), copy = frames_in(folder + "/copy.mkv");
  REQUIRE(original.size() == 40);
  REQUIRE(copy.size() == original.size());
  for (std::size_t i = 0; i < copy.size(); ++i) CHECK(sample::same(copy[i], original[i]));
  const auto lens_of = [](const std::string& file) {
    return value_of(open_recording(posix_storage(), file))->camera().intrinsics.has_value();
  };
  CHECK(lens_of(folder + "/walk.mkv"));
  CHECK(lens_of(folder + "/copy.mkv"));

  require_success(
      {"record", "--camera", "replay:" + folder + "/walk.mkv", "--frames", "5", "-o", folder + "/first.mkv"});
  CHECK(frames_in(folder + "/first.mkv").size() == 5);
}

TEST_CASE(
    "every verb that writes a recording writes the codec that it is told, and repair the one that it reads") {
  const std::string folder = sample::scratch_folder("codecs"), walk = folder + "/huffyuv.mkv";
  require_success({"simulate", "walk?size=64x48", "--shutter", "1ms,4ms", "--frames", "8", "-o", walk,
                   "--truth", folder + "/clip"});
  const std::vector<std::vector<std::string>> small{
      {"simulate", "walk?size=64x48", "--shutter", "1ms,4ms", "--frames", "8", "-o",
       folder + "/simulated.mkv"},
      {"import", folder + "/clip", "-o", folder + "/imported.mkv"},
      {"record", "--camera", "replay:" + walk, "-o", folder + "/copied.mkv"},
      {"record", "--camera", "sim:walk?size=64x48", "--frames", "8", "-o", folder + "/recorded.mkv"},
      {"live", "--camera", "replay:" + walk, "--record", folder + "/replayed.mkv"},
      {"live", "--camera", "sim:walk?size=64x48", "--frames", "8", "--record", folder + "/live.mkv"}};
  const auto codec_in = [](const std::string& file) {
    return value_of(open_recording(posix_storage(), file))->codec();
  };
  CHECK(codec_in(walk) == RecordingCodec::Huffyuv);
  for (std::vector<std::string> words : small) {
    words.insert(words.end(), {"--record-codec", "ffv1"});
    require_success(words);
  }
  const auto original = frames_in(walk);
  for (const char* name : {"simulated", "imported", "copied", "recorded", "replayed", "live"}) {
    CAPTURE(name);
    const std::string file = folder + "/" + name + ".mkv", repaired = folder + "/" + name + "_repaired.mkv";
    CHECK(codec_in(file) == RecordingCodec::Ffv1);
    require_success({"repair", file, "-o", repaired});
    CHECK(codec_in(repaired) == RecordingCodec::Ffv1);
  }
  const auto copy = frames_in(folder + "/copied.mkv");
  REQUIRE(copy.size() == original.size());
  for (std::size_t i = 0; i < copy.size(); ++i) CHECK(sample::same(copy[i].codes, original[i].codes));
}

TEST_CASE("wrong exposures of a clip are put right by import, replay and live, or are an error") {
  const std::string folder = sample::scratch_folder("wrong_labels");
  require_success({"simulate", "walk?size=160x120", "--shutter", "1ms,4ms,16ms", "--frames", "18", "-o",
                   folder + "/right.mkv"});
  // every label is the next frame's
  {
    auto frames = frames_in(folder + "/right.mkv");
    const auto reader = value_of(open_recording(posix_storage(), folder + "/right.mkv"));
    const auto writer = value_of(create_recording(posix_storage(), folder + "/wrong.mkv", reader->camera()));
    std::vector<double> exposures_s;
    for (const RawFrame& frame : frames) exposures_s.push_back(frame.facts.exposure_s);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].facts.exposure_s = exposures_s[(i + 1) % 3];
      frames[i].facts.slot = static_cast<int>((i + 1) % 3);
      REQUIRE(writer->append(frames[i]).ok());
    }
    REQUIRE(writer->finish().ok());
  }
  const auto wrong_in = [&](const std::string& stats) {
    int wrong = 0;
    const double cycle[] = {0.25, 1, 4};  // E / E_ref
    const auto json = json_in(stats);
    for (const auto& frame : json["per_frame"])
      wrong += frame["exposure"].get<double>() != Approx(cycle[frame["sequence"].get<int>() % 3]);
    CHECK(json["per_frame"].size() >= 16);
    CHECK(json["notes"].dump().find("relabelled by their pictures") != std::string::npos);
    return wrong;
  };
  const std::string stats = folder + "/stats.json";
  require_success({"replay", folder + "/wrong.mkv", "--emit", "state", "--stats", stats});
  CHECK(wrong_in(stats) == 0);
  require_success(
      {"live", "--camera", "replay:" + folder + "/wrong.mkv", "--emit", "state", "--stats", stats});
  CHECK(wrong_in(stats) == 0);
  check_refused({"replay", folder + "/wrong.mkv", "--strict", "--stats", stats}, ErrorCode::BadExposure,
                "frame 0");
  require_success({"replay", folder + "/right.mkv", "--strict", "--emit", "state", "--stats", stats});

  require_success({"export", folder + "/wrong.mkv", "-o", folder + "/clip"});
  check_refused({"import", folder + "/clip", "-o", folder + "/strict.mkv", "--strict"},
                ErrorCode::BadExposure, "frame 0");
  const RanHere imported = ran_here({"import", folder + "/clip", "-o", folder + "/imported.mkv"});
  REQUIRE(imported.exit_code == kExitOk);
  int photometric = 0;
  for (const RawFrame& frame : frames_in(folder + "/imported.mkv"))
    photometric += frame.facts.exposure_source == ExposureSource::Photometric;
  CHECK(photometric >= 16);
}

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

TEST_CASE("a flag that a run would ignore is refused, and a file of settings that holds it is not") {
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
                                    {"--adapt", "light"},
                                    {"--mains", "50"}})
    for (const char* pace : {"fit", "realtime"})
      check_refused(with({"--pace", pace, flag, value}), ErrorCode::Invalid,
                    std::string("are recorded and cannot be set; leave out ") + flag);
  check_refused({"live", "--camera", "replay:" + walk, "--adapt", "motion"}, ErrorCode::Invalid, "--adapt");
  for (const auto& [flag, value] : {std::pair("--buffers", "6"),
                                    {"--control-delay", "2,1"},
                                    {"--timestamp", "begin"},
                                    {"--yuv-range", "full"},
                                    {"--sync-line", "gpiochip0:17"},
                                    {"--strobe", "exposure"},
                                    {"--record-memory", "64"}})
    check_refused(with({flag, value}), ErrorCode::Invalid,
                  std::string("give --pace realtime to play it as a camera, or leave out ") + flag);
  check_refused({"live", "--camera", "sim:still", "--pace", "realtime"}, ErrorCode::Invalid,
                "give --camera replay:FILE, or leave out --pace");
  check_refused({"live", "--camera", "sim:still", "--strict"}, ErrorCode::Invalid,
                "--strict is for a recording");
  check_refused({"live", "--camera", "replay:" + walk, "--pace", "realtime", "--strict"}, ErrorCode::Invalid,
                "not with --pace realtime");
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
  CHECK_FALSE(std::filesystem::exists(folder + "/s.json"));
  const std::string page_alone = "give --http 127.0.0.1:8080 too";
  check_refused({"live", "--camera", "sim:still", "--http-token", "abc"}, ErrorCode::Invalid, page_alone);
  check_refused({"live", "--camera", "sim:still", "--http-record", folder + "/%03d.mkv"}, ErrorCode::Invalid,
                page_alone);
  check_refused({"replay", walk, "--stats", folder + "/s.json", "--http-token", "abc"}, ErrorCode::Invalid,
                page_alone);
  CHECK_FALSE(std::filesystem::exists(folder + "/copy.mkv"));

  const std::string file = folder + "/rig.toml",
                    text = "[camera]\nwidth = 128\n[schedule]\nadapt = \"light\"\n";
  REQUIRE(write_whole(posix_storage(), file, std::as_bytes(std::span(text))).ok());
  require_success(with({"--config", file}));
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
    check_refused(words, ErrorCode::Invalid, "--http-record needs a camera");
    words.resize(size);
    words.insert(words.end(), {"--config", file});
    require_success(words);
    CHECK(json_in(stats)["command"].get<std::string>().find("--http-record") == std::string::npos);
  }
}

TEST_CASE("live names its recording among its outputs, also where a recording stands in for the camera") {
  const std::string folder = sample::scratch_folder("live_names_recording"), copy = folder + "/copy.mkv";
  require_success({"simulate", "walk?size=64x48", "--frames", "6", "-o", folder + "/walk.mkv"});
  const test::Ran ended = test::ran(std::vector<std::string>{
      "live", "--camera", "replay:" + folder + "/walk.mkv", "--preset", "realtime", "--record", copy});
  INFO(ended.output);
  REQUIRE(ended.exit_code == kExitOk);
  CHECK(ended.output.find(copy + ": 6 of 6 frames") != std::string::npos);
}

TEST_CASE("a recording runs through live like a camera, to its end") {
  const std::string folder = sample::scratch_folder("live_replay");
  require_success({"record", "--camera", "sim:still?size=64x48&fps=60", "--format", "RGB24", "--shutter",
                   "1ms,4ms", "--frames", "24", "-o", folder + "/raw.mkv"});
  require_success({"live", "--camera", "replay:" + folder + "/raw.mkv", "--pace", "realtime", "--preset",
                   "fast", "--emit", "state", "-o", folder + "/%06d.exr", "--stats", folder + "/stats.json"});
  const auto counters = json_in(folder + "/stats.json")["counters"];
  CHECK(counters["captured"] == 24);
  CHECK(counters["emitted"].get<int>() + counters["dropped"].get<int>() == 24);
  CHECK(counters["camera.proved"].get<int>() >= 16);
}

TEST_CASE("a raw camera is recorded raw, and its recording becomes HDR frames") {
  const std::string folder = sample::scratch_folder("live_raw");
  require_success({"record", "--camera", "sim:still?size=64x48&fps=60", "--shutter", "1ms,4ms", "--frames",
                   "12", "-o", folder + "/raw.mkv"});
  auto reader = value_of(open_recording(posix_storage(), folder + "/raw.mkv"));
  CHECK(reader->camera().layout == PixelLayout::BayerRggb);
  CHECK(reader->camera().bits == 16);
  CHECK(reader->camera().linear);
  require_success({"replay", folder + "/raw.mkv", "--preset", "fast", "-o", folder + "/%06d.exr"});
  CHECK(files_in(folder, ".exr") == 12);
}

TEST_CASE("a black level that the user states reaches recording and fit, of raw and of processed codes") {
  for (const std::string format : {"", "RGB24"}) {
    const std::string folder = sample::scratch_folder("live_black");
    std::vector<std::string> words{"live",
                                   "--camera",
                                   "sim:still?size=64x48&fps=60&black=0.06",
                                   "--shutter",
                                   "1ms,4ms",
                                   "--preset",
                                   "fast",
                                   "--emit",
                                   "state",
                                   "--frames",
                                   "16",
                                   "--black-level",
                                   "15.3",
                                   "--record",
                                   folder + "/raw.mkv",
                                   "--stats",
                                   folder + "/live.json"};
    if (!format.empty()) words.insert(words.end(), {"--format", format});
    require_success(words);
    require_success({"replay", folder + "/raw.mkv", "--preset", "fast", "--emit", "state", "--stats",
                     folder + "/replay.json"});
    CAPTURE(format);
    for (const RawFrame& frame : frames_in(folder + "/raw.mkv")) {
      REQUIRE(frame.facts.black_level);
      CHECK((*frame.facts.black_level)[1] == Approx(15.3));
    }
    for (const char* stats : {"/live.json", "/replay.json"}) {
      const std::string notes = json_in(folder + stats)["notes"].dump();
      CAPTURE(stats, notes);
      CHECK(notes.find("black level: 15.3, 15.3, 15.3 codes of 255") != std::string::npos);
    }
  }
}

TEST_CASE("a cycle of equal exposures is refused") {
  check_refused({"live", "--camera", "sim:still", "--shutter", "1ms,1ms,1ms"}, ErrorCode::Invalid,
                "all 3 exposures of the cycle are the same");
}

TEST_CASE("a camera that reports nothing is calibrated once and then labelled right") {
  const std::string folder = sample::scratch_folder("live_calibrated");
  const std::string camera = "sim:still?size=96x72&fps=100&reports=no&delay=3,1";
  require_success({"calibrate", "delay", "--camera", camera, "--format", "RGB24", "--shutter", "1ms,4ms",
                   "-o", folder + "/camera.toml"});
  const std::string toml = value_of(read_whole(posix_storage(), folder + "/camera.toml"));
  CHECK(toml.find("3,1") + toml.find("[3, 1]") != 2 * std::string::npos);
  require_success({"record", "--config", folder + "/camera.toml", "--shutter", "1ms,4ms", "--frames", "60",
                   "-o", folder + "/raw.mkv"});
  const auto frames = frames_in(folder + "/raw.mkv");
  REQUIRE(frames.size() == 60);
  int flagged = 0;
  double brightness[2] = {0, 0};
  for (const RawFrame& frame : frames) {
    if ((frame.facts.flags & kFrameExposureUnproved) != 0) {
      ++flagged;
      continue;
    }
    // The scene stands still: a frame is as bright as the others of its label.
    double sum = 0;
    for (const std::uint16_t code : frame.codes.samples()) sum += code;
    double& expected = brightness[frame.facts.exposure_s > 0.002 ? 1 : 0];
    if (expected == 0) expected = sum;
    CHECK(sum == Approx(expected).epsilon(0.05));
  }
  CHECK(brightness[1] > 1.3 * brightness[0]);
  CHECK(flagged <= 12);
}

TEST_CASE("a calibration replaces an earlier configuration with --force only, and a recording never") {
  const std::string folder = sample::scratch_folder("live_calibration_kept"), text = "an earlier one";
  std::vector<std::string> words{"calibrate", "delay", "--camera", "sim:still?size=64x48", "-o", ""};
  for (const char* file : {"/camera.toml", "/take.mkv"}) {
    const std::string path = words.back() = folder + file;
    require_done(write_whole(posix_storage(), path, std::as_bytes(std::span(text))));
    check_refused(words, path.ends_with(".toml") ? ErrorCode::Exists : ErrorCode::Invalid, path);
    CHECK(value_of(read_whole(posix_storage(), path)) == text);
  }
  words.emplace_back("--force");
  check_refused(words, ErrorCode::Invalid, "a picture or a recording");
}

TEST_CASE("what cannot be is said before the camera starts, each with its own exit code") {
  const std::string sim = "sim:still?size=64x48";
  check_refused({"live", "--camera", "sim:nosuch"}, ErrorCode::NotFound, "nosuch");
  check_refused({"live", "--camera", "replay:/nonexistent.mkv"}, ErrorCode::NotFound, "/nonexistent.mkv");
  check_refused({"live", "--camera", "/dev/video99"}, ErrorCode::NotFound, "/dev/video99");
  check_refused({"live", "--camera", sim, "--format", "YUYV"}, ErrorCode::Unsupported, "YUYV");
  check_refused({"live", "--camera", sim, "--shutter", "1ms,200ms"}, ErrorCode::BadExposure, "200 ms");
  check_refused({"live", "--camera", sim, "--shutter", "1ms,4ms", "--gain", "1,99"}, ErrorCode::BadExposure,
                "99");
  check_refused({"live", "--camera", sim, "--shutter", "1ms,zwei"}, ErrorCode::Invalid, "zwei");
  check_refused({"live", "--camera", sim, "--control-delay", "2;1"}, ErrorCode::Invalid, "2;1");
  check_refused({"live", "--camera", sim, "--preset", "slow"}, ErrorCode::Invalid, "slow");
  check_refused({"record", "--camera", sim}, ErrorCode::Invalid, "-o");
  check_refused({"record", "--camera", sim, "-o", "-"}, ErrorCode::Invalid, "name it as walk.mkv");
  check_refused({"live", "--camera", sim, "--record", "x.mp4"}, ErrorCode::Invalid, "name it as walk.mkv");
  check_refused({"record", "--camera", sim, "-o", "/proc/nonexistent/x.mkv"}, ErrorCode::NotFound,
                "/proc/nonexistent");
  check_refused({"calibrate", "gain", "--camera", sim}, ErrorCode::Invalid, "'gain'");
  check_refused({"calibrate", "delay", "--camera", sim, "--shutter", "4ms"}, ErrorCode::Invalid,
                "no two exposures of --shutter 4ms are a stop apart");
}

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
    for (int i = 0; i < 1000 && files_in(folder, ".exr") < 5; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
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

TEST_CASE("^C before there are frames enough for an HDR frame is no failure either") {
  const std::string folder = sample::scratch_folder("live_stopped_at_once"), raw = folder + "/raw.mkv";
  const pid_t process =
      started({"live", "--camera", "sim:still?size=64x48&fps=2", "--shutter", "1ms,4ms", "--format", "RGB24",
               "--preset", "fast", "-o", folder + "/%06d.exr", "--record", raw});
  for (int i = 0; i < 1000 && value_of(posix_storage().look_at(raw)).kind == FileKind::Missing; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  kill(process, SIGINT);  // one frame is there; two are the least
  int status = 0;
  REQUIRE(waitpid(process, &status, 0) == process);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == kExitOk);
  CHECK(value_of(open_recording(posix_storage(), raw))->frame_count());
}

// However busy the machine is.
void wait_for_size(const std::string& path, std::uintmax_t bytes) {
  for (int i = 0; i < 3000; ++i) {
    std::error_code missing;
    const std::uintmax_t size = std::filesystem::file_size(path, missing);
    if (!missing && size >= bytes) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
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
    if (i % 3 != 0) wait_for_size(path, 64 << 10);  // others are killed as early as it comes
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

TEST_CASE("a recorder that is killed leaves a readable recording, each frame with its own exposure") {
  survives_kills(12);
}

TEST_CASE("a recorder that is killed at a thousand moments leaves a readable recording each time",
          "[.][full]") {
  survives_kills(1000);
}
