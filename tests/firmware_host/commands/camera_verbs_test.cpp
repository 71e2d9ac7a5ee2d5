// The verbs that run a camera, live, record and calibrate, as a user meets them, on simulated and replayed
// cameras.
#include <chrono>
#include <filesystem>
#include <span>

#include "hal/core/counted.h"
#include "hal/fault/faulty_storage.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/firmware_host/commands/verb_runs.h"
#include "tests/support/files.h"
#include "tests/support/ran.h"

using namespace hdrcam;
using test::check_refused;
using test::files_in;
using test::frames_in;
using test::json_in;
using test::ran_here;
using test::RanHere;
using test::require_success;

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

TEST_CASE("record says how the cycle followed the light") {
  const std::string recording = sample::scratch_folder("record_light") + "/x.mkv";
  const test::Ran ended =
      test::ran({"record", "--camera", "sim:walk?size=64x48&rays=1&fps=50", "--format", "RGB24", "--shutter",
                 "8ms,16ms", "--adapt", "light", "--frames", "60", "-o", recording});
  REQUIRE(ended.exit_code == kExitOk);
  CHECK_THAT(ended.output, Catch::Contains("the light changed the cycle") && Catch::Contains("; last to "));
}

TEST_CASE("a deadline that nothing can hold costs previews and HDR frames, never captured or recorded ones") {
  const std::string folder = sample::scratch_folder("live_late");
  const test::Ran ended =
      test::ran({"live", "--camera", "sim:still?size=128x96&rays=1&fps=20", "--format", "RGB24", "--shutter",
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

TEST_CASE("a recording of a camera that a full disk cuts is said to be so, with how many frames it has") {
  const std::string folder = sample::scratch_folder("record_full"), path = folder + "/raw.mkv";
  require_success(
      {"simulate", "walk?size=64x48", "--shutter", "1ms,4ms", "--frames", "60", "-o", folder + "/walk.mkv"});
  const std::vector<std::string> camera{
      "--camera", "sim:still?size=64x48&fps=200", "--format", "RGB24", "--shutter", "1ms,4ms"};
  std::vector<std::string> record{"record", "-o", path},
      live{"live", "--preset", "fast", "--emit", "state", "--record", path};
  const std::vector<std::string> copy{"record", "-o", path, "--camera", "replay:" + folder + "/walk.mkv"};
  for (auto* words : {&record, &live}) words->insert(words->end(), camera.begin(), camera.end());
  for (const auto& words : {record, live, copy}) {
    FaultyStorage full(posix_storage(), {.space_bytes = 40'000});
    const RanHere run = ran_here(words, full);
    const auto frames = static_cast<int>(frames_in(path).size());
    CAPTURE(words, run.err, frames);
    CHECK(run.exit_code == exit_code_of(ErrorCode::NoSpace));
    CHECK(frames >= 1);
    CHECK_THAT(run.err,
               Catch::Contains(fmt::format("'{0}' is cut after {1}, of which 'hdrcam repair {0} -o FILE'",
                                           path, counted(frames, "frame"))));
    std::filesystem::remove(path);
  }
}

TEST_CASE("a recording that is cut is told of where another output finds no room either") {
  const std::string path = sample::scratch_folder("live_full") + "/raw.mkv";
  const test::Ran run = test::ran(
      "live --preset fast --emit state --camera 'sim:still?size=64x48&fps=200' --format RGB24 "
      "--shutter 1ms,4ms --frames 600 --stats /dev/full --record " +
          path,
      "trap '' XFSZ; ulimit -f 100;");  // no file grows beyond so many blocks
  const auto frames = static_cast<int>(frames_in(path).size());
  CAPTURE(run.output, frames);
  CHECK(run.exit_code == exit_code_of(ErrorCode::NoSpace));
  CHECK(frames >= 1);
  CHECK_THAT(run.output, Catch::Contains("hdrcam: '" + path + "'"));  // it ended the run
  CHECK_THAT(run.output, Catch::Contains("warning: no space left to write '/dev/full'"));
  CHECK_THAT(run.output,
             Catch::Contains(fmt::format("'{0}' is cut after {1}, of which 'hdrcam repair {0} -o FILE'", path,
                                         counted(frames, "frame"))));
}

TEST_CASE(
    "a damaged frame of a recording that stands in for the camera is not counted among those that came") {
  const std::string folder = sample::scratch_folder("live_damaged"), walk = folder + "/walk.mkv";
  require_success({"simulate", "walk?size=64x48", "--shutter", "1ms,4ms", "--frames", "12", "-o", walk});
  std::string bytes = value_of(read_whole(posix_storage(), walk));
  bytes[bytes.size() * 7 / 10] ^= 1;
  require_done(write_whole(posix_storage(), walk, std::as_bytes(std::span(bytes))));
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"live", "--emit", "state", "--record"}, {"record", "-o"}}) {
    std::vector<std::string> line = words;
    line.insert(line.end(), {folder + "/" + words.front() + ".mkv", "--camera", "replay:" + walk});
    const test::Ran ended = test::ran(line);
    INFO(ended.output);
    CHECK(ended.exit_code == kExitOk);
    CHECK(ended.output.find("1 damaged frame left out") != std::string::npos);
    CHECK(ended.output.find("11 frames; exposures: ") != std::string::npos);
  }
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
    CHECK(json["notes"].dump().find("relabelled from the pictures") != std::string::npos);
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

TEST_CASE("a damaged frame of a recording is one that the camera lost, and is named") {
  const std::string folder = sample::scratch_folder("live_damaged"), path = folder + "/walk.mkv";
  require_success({"simulate", "walk?size=64x48", "--frames", "24", "-o", path});
  std::string bytes = read_whole(posix_storage(), path).value();
  bytes[bytes.find("{\"index\":9,") - 30] ^= 1;
  test::write_file(path, bytes);
  for (const std::string verb : {"live", "record"}) {
    std::vector<std::string> words{verb, "--camera", "replay:" + path, "--pace", "realtime"};
    if (verb == "live")
      words.insert(words.end(), {"--preset", "realtime", "--stats", folder + "/stats.json"});
    else
      words.insert(words.end(), {"-o", folder + "/copy.mkv"});
    const test::Ran ended = test::ran(words);  // the log is that of a process
    INFO(ended.output);
    REQUIRE(ended.exit_code == kExitOk);
    const std::string told = "warning: 1 damaged frame left out: 9 (";
    const auto first = ended.output.find(told);
    REQUIRE(first != std::string::npos);
    CHECK(ended.output.find(told, first + 1) == std::string::npos);
  }
  const auto stats = json_in(folder + "/stats.json");
  const auto& counters = stats["counters"];
  CHECK(counters["captured"] == 23);
  CHECK(counters["camera.lost"] == 1);
  CHECK(counters["emitted"].get<int>() + counters["dropped"].get<int>() == 23);
  CHECK(stats["notes"].dump().find("1 damaged frame left out: 9 (") != std::string::npos);
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

TEST_CASE("a calibration that no pictures allow says what scene and what light it needs") {
  const test::Ran failed = test::ran(
      {"calibrate", "delay", "--camera", "sim:night?size=32x32&fps=200&reports=no", "--shutter", "1ms,4ms"});
  INFO(failed.output);
  CHECK(failed.exit_code == exit_code_of(ErrorCode::TooShort));
  CHECK(failed.output.find(
            "a static scene that is neither black nor clipped, in light that does not flicker") !=
        std::string::npos);
}

TEST_CASE("a camera that reports nothing is calibrated once and then labelled right") {
  const std::string folder = sample::scratch_folder("live_calibrated"), file = folder + "/my camera.toml";
  const std::string camera = "sim:still?size=96x72&fps=100&reports=no&delay=3,1";
  const test::Ran calibration = test::ran(
      {"calibrate", "delay", "--camera", camera, "--format", "RGB24", "--shutter", "1ms,4ms", "-o", file});
  REQUIRE(calibration.exit_code == 0);
  CHECK(calibration.output.find("use it with --config '" + file + "'") != std::string::npos);
  const std::string toml = value_of(read_whole(posix_storage(), file));
  CHECK(toml.find("3,1") + toml.find("[3, 1]") != 2 * std::string::npos);
  require_success(
      {"record", "--config", file, "--shutter", "1ms,4ms", "--frames", "60", "-o", folder + "/raw.mkv"});
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
