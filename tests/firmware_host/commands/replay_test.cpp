// The main job from outside: the program, a recording, and what it leaves on the disk.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "firmware_host/exit_code.h"
#include "hal/fault/faulty_storage.h"
#include "hal/recording/recording.h"
#include "render/exr.h"
#include "render/hdr_frame.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/dng_file.h"
#include "tests/support/moving_scene.h"
#include "tests/support/ran_here.h"

#include "tests/support/files.h"
#include "tests/support/ran.h"

using namespace hdrcam;
using test::ran_here;
using test::RanHere;
using test::text_of;
namespace fs = std::filesystem;

namespace {

const std::string kDemo = HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";

std::string write_clip(const std::string& folder, int frames) {
  const test::MovingScene scene;
  const std::string path = folder + "/clip.mkv";
  auto writer = create_recording(posix_storage(), path, scene.camera()).value();
  for (int i = 0; i < frames; ++i) REQUIRE(writer->append(scene.frame(i)).ok());
  REQUIRE(writer->finish().ok());
  return path;
}

std::vector<std::string> files_in(const std::string& folder, const std::string& extension) {
  std::vector<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == extension) names.push_back(entry.path().string());
  std::sort(names.begin(), names.end());
  return names;
}

// Of a replay of some frames that a camera writes as they are, behind a mosaic.
nlohmann::json stats_of_raw(const std::string& name, const std::string& scene = "still?size=64x48",
                            int frames = 6) {
  const std::string folder = sample::scratch_folder(name), path = folder + "/raw.mkv";
  REQUIRE(ran_here({"simulate", scene, "-o", path, "--frames", std::to_string(frames), "--format", "bayer"})
              .exit_code == 0);
  REQUIRE(ran_here({"replay", path, "--preset", "fast", "--emit", "state", "--stats", folder + "/stats.json"})
              .exit_code == 0);
  return nlohmann::json::parse(read_whole(posix_storage(), folder + "/stats.json").value());
}

}  // namespace

TEST_CASE("a damaged frame is dropped and named, --strict ends with it, and the ledger adds up") {
  const std::string folder = sample::scratch_folder("replay_damaged");
  const std::string path = write_clip(folder, 9);
  FaultyStorage disk(posix_storage(), {.flipped_bits = {fs::file_size(path) * 8 * 7 / 10}});
  const std::vector<std::string> words{"replay",
                                       path,
                                       "--preset",
                                       "fast",
                                       "--emit",
                                       "state",
                                       "--force",
                                       "-o",
                                       folder + "/out/%06d.exr",
                                       "--stats",
                                       folder + "/stats.json"};
  const RanHere went_on = ran_here(words, disk);
  INFO(went_on.err);
  REQUIRE(went_on.exit_code == 0);
  CHECK(files_in(folder + "/out", ".exr").size() == 8);
  const auto stats = nlohmann::json::parse(read_whole(posix_storage(), folder + "/stats.json").value());
  CHECK(stats["captured"] == 9);
  CHECK(stats["emitted"] == 8);
  CHECK(stats["dropped"] == 1);
  CHECK(stats["counters"]["dropped.damaged"] == 1);
  CHECK(stats["notes"].dump().find("1 damaged frame left out: ") != std::string::npos);

  std::vector<std::string> strict = words;
  strict.push_back("--strict");
  CHECK(ran_here(strict, disk).exit_code == exit_code_of(ErrorCode::Corrupt));
}

TEST_CASE("what interpolating a mosaic leaves in textures is not called the camera's processing") {
  const std::string notes = stats_of_raw("replay_mosaic")["notes"].dump();
  INFO(notes);
  CHECK(notes.find("colours of a mosaic: a sample's variance has 2 % of the local contrast") !=
        std::string::npos);
  CHECK(notes.find("the camera processes textures") == std::string::npos);
}

TEST_CASE("what raw pictures differ by beyond their mosaic is not called the camera's processing") {
  const std::string notes =
      stats_of_raw("replay_mosaic_and_more", "night?seed=6&size=96x72", 10)["notes"].dump();
  INFO(notes);
  CHECK(notes.find("colours of a mosaic, and what else pictures differ by: a sample's variance has ") !=
        std::string::npos);
  CHECK(notes.find("the camera processes textures") == std::string::npos);
}

TEST_CASE("the response of a raw recording is told as its camera's: linear") {
  const nlohmann::json response = stats_of_raw("replay_raw_response")["response"];
  REQUIRE(response.size() == 3);
  for (const nlohmann::json& channel : response)
    for (const std::size_t code : {8, 64, 128, 255})
      CHECK(channel[code].get<double>() == Approx(static_cast<double>(code) / 255));
}

TEST_CASE("the command in the report is the whole command, as a shell takes it") {
  const std::string folder = sample::scratch_folder("replay it's");
  const std::string path = write_clip(folder, 7), stats = folder + "/stats.json";
  REQUIRE(ran_here({"replay", path, "--preset", "fast", "--emit", "state", "--frames", "7", "--strict",
                    "--stats", stats})
              .exit_code == 0);
  const auto json = nlohmann::json::parse(read_whole(posix_storage(), stats).value());
  const std::string command = json["command"];
  INFO(command);
  CHECK(command.find("/replay it'\\''s/clip.mkv'") != std::string::npos);
  for (const char* word : {"--preset=fast", "--emit=state", "--frames 7", "--strict", "--stats='"})
    CHECK(command.find(word) != std::string::npos);
}

TEST_CASE("the token of the live view stands in no file of a run, and in no word that it prints") {
  const std::string folder = sample::scratch_folder("replay_token"), token = "5ec2e70fthe11vev1ew";
  const test::Ran outcome = test::ran(std::vector<std::string>{
      "replay", write_clip(folder, 7), "--preset", "fast", "--emit", "state", "--http", "127.0.0.1:0",
      "--http-token", token, "--stats", folder + "/stats.json", "--report", folder + "/report.html",
      "--trace", folder + "/trace.json", "-o", folder + "/out/%06d.exr"});
  INFO(outcome.output);
  REQUIRE(outcome.exit_code == 0);
  CHECK(outcome.output.find("live view: http://127.0.0.1:") != std::string::npos);
  CHECK(outcome.output.find(token) == std::string::npos);
  std::set<std::string> kinds;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
    if (!file.is_regular_file()) continue;
    INFO(file.path());
    CHECK(test::text_of(file.path()).find(token) == std::string::npos);
    kinds.insert(file.path().extension());
  }
  CHECK(kinds == std::set<std::string>{".csv", ".exr", ".html", ".json", ".mkv"});
}

TEST_CASE("a replay prints the address of its live view without a token, which nothing there needs") {
  const std::string folder = sample::scratch_folder("replay_no_token");
  const test::Ran outcome = test::ran(std::vector<std::string>{
      "replay", write_clip(folder, 7), "--preset", "fast", "--emit", "state", "--http", "127.0.0.1:0"});
  INFO(outcome.output);
  CHECK(outcome.exit_code == 0);
  CHECK(outcome.output.find("live view: http://127.0.0.1:") != std::string::npos);
  CHECK(outcome.output.find("token") == std::string::npos);
}

TEST_CASE("a run that needs more memory than it may take is refused in one sentence before it starts") {
  const std::string folder = sample::scratch_folder("replay_memory");
  const std::string path = folder + "/claim.mkv";
  // 16384x240 pixels in a small file
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 16384, 240);
  auto frames = sample::frames(camera, 7, 1);
  for (RawFrame& frame : frames) std::ranges::fill(frame.codes.samples(), std::uint16_t{7});
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto begin = std::chrono::steady_clock::now();
  const RanHere refused = ran_here({"replay", path, "--memory", "1024", "-o", folder + "/%06d.exr"});
  CHECK(refused.exit_code == exit_code_of(ErrorCode::Unsupported));
  for (const char* words :
       {"the fit of pictures of 16384x240 needs about", "1024 MiB are allowed", "--memory"})
    CHECK(refused.err.find(words) != std::string::npos);
  CHECK(files_in(folder, ".exr").empty());
  CHECK(ran_here({"export", path, "--memory", "64", "-o", folder + "/clip"})
            .err.find("a copy of frames of 16384x240") != std::string::npos);
  const RanHere scene =
      ran_here({"simulate", "walk?size=4096x4096", "--memory", "1024", "-o", folder + "/x.mkv"});
  CHECK(scene.err.find("a scene of 4096x4096 needs about") != std::string::npos);
  const RanHere stream = ran_here({"live", "--camera", "sim:still", "--width", "20000", "--height", "20000",
                                   "--memory", "4096", "-o", folder + "/%06d.exr"});
  CHECK(stream.exit_code == exit_code_of(ErrorCode::Unsupported));
  CHECK(stream.err.find("a stream of 20000x20000 with its fit needs about") != std::string::npos);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(30));
}

TEST_CASE(
    "the demo recording becomes HDR frames brighter than any LDR level, a preview, statistics and a report") {
  const std::string out = sample::scratch_folder("replay_demo");
  const RanHere outcome =
      ran_here({"replay", kDemo, "-o", out + "/%06d.exr", "--frames", "8", "--preset", "fast", "--layers",
                "depth,flow,confidence,provenance", "--preview", out + "/preview/%06d.png", "--stats",
                out + "/stats.json", "--sheet", out + "/sheet.png", "--report", out + "/report.html"});
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  const auto frames = files_in(out, ".exr");
  REQUIRE(frames.size() == 8);
  float brightest = 0;
  for (const auto& path : frames) {
    const auto picture = read_exr(posix_storage(), path).value();
    for (const float v : picture.samples.samples()) REQUIRE(std::isfinite(v));
    for (const auto& name : exr_channel::kRadiance) {
      const auto channel = picture.find(name);
      REQUIRE(channel.has_value());
      const float* plane = picture.samples.plane(*channel);
      brightest = std::max(brightest, *std::max_element(plane, plane + picture.samples.plane_size()));
    }
  }
  CHECK(brightest > 1.5f);  // 1 is the brightest level of the reference exposure
  CHECK(files_in(out + "/preview", ".png").size() == 8);
  CHECK(text_of(out + "/stats.json").find("\"ms_per_frame\"") != std::string::npos);
  CHECK(text_of(out + "/report.html").find("</html>") != std::string::npos);
  CHECK(fs::file_size(out + "/sheet.png") > 1000);
}

TEST_CASE("one thread and two leave the same bytes, another seed leaves others") {
  const std::string folder = sample::scratch_folder("replay_threads"), clip = write_clip(folder, 7);
  const auto replay_to = [&](const std::string& name, const std::string& threads, const std::string& seed) {
    REQUIRE(ran_here({"replay", clip, "-o", folder + "/" + name + "/%06d.exr", "--emit", "field", "--preset",
                      "fast", "--threads", threads, "--seed", seed})
                .exit_code == 0);
    std::vector<std::string> all;
    for (const auto& path : files_in(folder + "/" + name, ".exr")) all.push_back(text_of(path));
    return all;
  };
  const auto one = replay_to("one", "1", "7");
  REQUIRE(one.size() == 7);
  CHECK(one == replay_to("two", "2", "7"));
  CHECK(one != replay_to("other", "1", "8"));
}

TEST_CASE(
    "a grey scene filmed as raw stills is grey with the white balance of its camera, and the sensor's "
    "colours without") {
  const std::string folder = sample::scratch_folder("replay_white");
  constexpr double kSensitivity[] = {0.5, 1,
                                     1 / 1.5};  // of red, green, blue; the stills state what undoes it
  for (int i = 0; i < 9; ++i) {
    test::DngStill still;
    still.shutter_per_s = std::array{1000u, 250u, 62u}[static_cast<std::size_t>(i % 3)];
    still.code_at = [&](int y, int x) {
      const double radiance =
          std::exp2(3 + 2 * std::sin(x * 0.21) * std::cos(y * 0.17) + std::sin(x * 0.05 + y * 0.09));
      const int color = still.pattern[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
      const double codes = 12000 * radiance * kSensitivity[color] / still.shutter_per_s;
      return static_cast<std::uint16_t>(std::min<double>(still.black + std::round(codes), still.white));
    };
    test::write_dng(fmt::format("{}/{}.dng", folder, i), still);
  }
  const std::string clip = folder + "/clip.mkv";
  REQUIRE(ran_here({"import", folder, "-o", clip}).exit_code == 0);
  const auto ratios = [&](const std::string& balance) {
    const std::string frames = folder + "/" + balance;
    REQUIRE(ran_here({"replay", clip, "-o", frames + "/%06d.exr", "--emit", "state", "--preset", "fast",
                      "--white-balance", balance})
                .exit_code == 0);
    const ExrImage last = read_exr(posix_storage(), files_in(frames, ".exr").back()).value();
    std::array<double, 3> mean{};
    for (std::size_t c = 0; c < 3; ++c)
      for (const float value :
           std::span(last.samples.plane(*last.find(exr_channel::kRadiance[c])), last.samples.plane_size()))
        mean[c] += static_cast<double>(value);
    CHECK(last.attributes.texts.contains("hdrcam.whiteBalance") == (balance == "camera"));
    return std::pair(mean[0] / mean[1], mean[2] / mean[1]);
  };
  const auto [red, blue] = ratios("camera");
  CHECK(red == Approx(1).epsilon(0.04));
  CHECK(blue == Approx(1).epsilon(0.04));
  const auto [sensor_red, sensor_blue] = ratios("none");
  CHECK(sensor_red == Approx(kSensitivity[0]).epsilon(0.04));
  CHECK(sensor_blue == Approx(kSensitivity[2]).epsilon(0.04));

  const RanHere refused =
      ran_here({"replay", kDemo, "-o", folder + "/x/%06d.exr", "--white-balance", "camera"});
  CHECK(refused.exit_code == exit_code_of(ErrorCode::Unsupported));
  CHECK(refused.err.find("states no white balance") != std::string::npos);
}

TEST_CASE("each layer can be had alone, and the field fills the state's picture where it is asked to") {
  const std::string folder = sample::scratch_folder("replay_layers");
  const auto replayed = [&](const char* layer, const char* fill) {
    const std::string frames = fmt::format("{}/{}_{}", folder, layer, fill);
    REQUIRE(
        ran_here({"replay", kDemo, "-o", frames + "/%06d.exr", "--emit", layer, "--set",
                  std::string("fill=") + fill, "--preset", "fast", "--layers", "provenance", "--frames", "8"})
            .exit_code == 0);
    std::vector<ExrImage> pictures;
    for (const auto& path : files_in(frames, ".exr"))
      pictures.push_back(read_exr(posix_storage(), path).value());
    REQUIRE(pictures.size() == 8);
    return pictures;
  };
  const auto state = replayed("state", "off"), beside = replayed("merged", "off"),
             merged = replayed("merged", "on"), field = replayed("field", "off");
  const auto plane = [](const ExrImage& picture, std::string_view name) {
    const auto channel = picture.find(name);
    REQUIRE(channel.has_value());
    return std::span(picture.samples.plane(*channel), picture.samples.plane_size());
  };
  constexpr auto kField = static_cast<float>(Provenance::Field);
  std::size_t answers = 0, elsewhere = 0, own = 0, of_field = 0, pixels = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const auto s = plane(state[i], "G"), m = plane(merged[i], "G"), f = plane(field[i], "G");
    CHECK(std::ranges::equal(plane(beside[i], "G"), s));
    const auto from_s = plane(state[i], exr_channel::kProvenance),
               from_m = plane(merged[i], exr_channel::kProvenance),
               from_f = plane(field[i], exr_channel::kProvenance);
    for (std::size_t p = 0; p < s.size(); ++p) {
      if (m[p] != s[p]) ++(from_m[p] == kField ? answers : elsewhere);
      own += from_s[p] == kField ? 0 : 1;
      of_field += from_f[p] == kField && f[p] != s[p] ? 1 : 0;
    }
    pixels += s.size();
  }
  CHECK(answers > 0);                 // filled, it is the state's picture ..
  CHECK(elsewhere == 0);              // .. but where the field answers,
  CHECK(own == pixels);               // the state knows no field,
  CHECK(10 * of_field > 9 * pixels);  // and the field alone is another picture
}

TEST_CASE("what cannot be is said in one sentence, with an exit code of its own") {
  const std::string folder = sample::scratch_folder("replay_errors");
  const std::string clip = write_clip(folder, 6), output = folder + "/out/%06d.exr";
  const auto expect = [&](int code, const std::string& word, const std::vector<std::string>& words) {
    const RanHere outcome = ran_here(words);
    INFO(outcome.err);
    CHECK(outcome.exit_code == code);
    CHECK(outcome.err.find(word) != std::string::npos);
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') >= 1);
  };
  expect(3, "nothing.mkv", {"replay", folder + "/nothing.mkv", "-o", output});
  expect(4, "CMakeLists.txt", {"replay", HDRCAM_SOURCE_DIR "/CMakeLists.txt", "-o", output});
  expect(2, "--speed", {"replay", clip, "--speed", "9"});
  expect(2, "preset", {"replay", clip, "--preset", "quick"});
  expect(2, "merged, state or field", {"replay", clip, "--emit", "all"});
  expect(2, "%0", {"replay", clip, "-o", folder + "/frame.exr"});
  fs::create_directories(folder + "/one");
  expect(9, "only one frame", {"replay", write_clip(folder + "/one", 1), "-o", output});
  std::ofstream(folder + "/file") << "in the way";
  expect(10, "file", {"replay", clip, "-o", folder + "/file/%06d.exr"});
}

TEST_CASE("where a run fails and its trace cannot be written either, both are told") {
  const std::string folder = sample::scratch_folder("trace_unwritten"), clip = write_clip(folder, 8);
  fs::resize_file(clip, fs::file_size(clip) * 6 / 10);
  const test::Ran outcome =
      test::ran(std::vector<std::string>{"replay", clip, "--preset", "fast", "--emit", "state", "--trace",
                                         "/dev/full", "-o", folder + "/out/%06d.exr"});
  INFO(outcome.output);
  CHECK(outcome.exit_code == 5);
  CHECK(outcome.output.find("warning: no space left to write '/dev/full'") != std::string::npos);
  CHECK(outcome.output.find("hdrcam: '" + clip + "' was cut after ") != std::string::npos);
}

TEST_CASE("a recording that was cut gives the frames before the cut and exit code 5") {
  const std::string folder = sample::scratch_folder("replay_cut"), clip = write_clip(folder, 8);
  fs::resize_file(clip, fs::file_size(clip) * 6 / 10);
  const RanHere outcome = ran_here({"replay", clip, "-o", folder + "/out/%06d.exr", "--emit", "state"});
  INFO(outcome.err);
  CHECK(outcome.exit_code == 5);
  CHECK(outcome.err.find(fmt::format("; 'hdrcam repair {} -o FILE' makes", clip)) != std::string::npos);
  const auto frames = files_in(folder + "/out", ".exr");
  CHECK(frames.size() >= 2);
  CHECK(frames.size() < 8);
  for (const auto& path : frames) CHECK(read_exr(posix_storage(), path).ok());
}

TEST_CASE("a full disk ends the run with exit code 11, and what is there is whole") {
  const std::string folder = sample::scratch_folder("replay_full"), clip = write_clip(folder, 6);
  FaultyStorage full(posix_storage(), {.space_bytes = 60'000});
  const RanHere outcome = ran_here({"replay", clip, "-o", folder + "/out/%06d.exr", "--emit", "state"}, full);
  INFO(outcome.err);
  CHECK(outcome.exit_code == 11);
  const auto frames = files_in(folder + "/out", ".exr");
  CHECK(frames.size() < 6);
  for (const auto& path : frames) CHECK(read_exr(posix_storage(), path).ok());
  CHECK(files_in(folder + "/out", ".part").empty());
}

TEST_CASE("where pictures contradict every exposure, the run says so, not that no frame came") {
  const std::string folder = sample::scratch_folder("replay_contradicted"), path = folder + "/clip.mkv";
  test::MovingScene scene;
  scene.exposures_s = {0.004};
  auto writer = create_recording(posix_storage(), path, scene.camera()).value();
  for (int i = 0; i < 12; ++i) {
    RawFrame frame = scene.frame(i);
    frame.facts.exposure_s = i % 2 == 0 ? 0.001 : 0.016;
    REQUIRE(writer->append(frame).ok());
  }
  REQUIRE(writer->finish().ok());
  const RanHere refused =
      ran_here({"replay", path, "--preset", "fast", "--emit", "state", "--stats", folder + "/stats.json"});
  CHECK(refused.exit_code == exit_code_of(ErrorCode::BadExposure));
  INFO(refused.err);
  CHECK(refused.err.find("12 frames came, and all are kept out of the fit") != std::string::npos);
  CHECK(refused.err.find("import the pictures with --shutter") != std::string::npos);
}

TEST_CASE("where neither a recording nor its pictures tell any exposure, the run says so") {
  const std::string folder = sample::scratch_folder("replay_unknown"), path = folder + "/clip.mkv";
  test::MovingScene scene;
  scene.exposures_s = {0.004};
  auto writer = create_recording(posix_storage(), path, scene.camera()).value();
  for (int i = 0; i < 6; ++i) {
    RawFrame frame = scene.frame(i);
    frame.facts.exposure_s = 0;
    frame.facts.exposure_source = ExposureSource::Unknown;
    frame.facts.flags = kFrameExposureUnproved;
    REQUIRE(writer->append(frame).ok());
  }
  REQUIRE(writer->finish().ok());
  const RanHere refused =
      ran_here({"replay", path, "--preset", "fast", "--emit", "state", "--stats", folder + "/stats.json"});
  INFO(refused.err);
  CHECK(refused.exit_code == exit_code_of(ErrorCode::BadExposure));
  CHECK(refused.err.find("6 frames came, and all are kept out of the fit, because their exposures are "
                         "unknown") != std::string::npos);
}

TEST_CASE("^C ends the run with exit code 130") {
  const std::string folder = sample::scratch_folder("replay_stop"), clip = write_clip(folder, 6);
  const RanHere outcome = ran_here({"replay", clip, "-o", folder + "/out/%06d.exr"}, posix_storage(), true);
  CHECK(outcome.exit_code == 130);
}

TEST_CASE("a replay's scores are of the frames that it wrote, and of no others in their folder") {
  const std::string folder = sample::scratch_folder("replay_scored"), walk = folder + "/walk.mkv",
                    clip = folder + "/clip", out = folder + "/out";
  REQUIRE(ran_here({"simulate", "walk?size=32x32", "--frames", "6", "-o", walk, "--truth", clip}).exit_code ==
          0);
  const auto scored = [&](const std::string& frames, const std::vector<std::string>& more) {
    std::vector<std::string> words{"replay", walk,   "--preset", "fast", "--emit",  "state",
                                   "-o",     frames, "--truth",  clip,   "--stats", folder + "/s.json"};
    words.insert(words.end(), more.begin(), more.end());
    return ran_here(words);
  };
  const RanHere named = scored(out + "/a_%06d.exr", {});
  CHECK(named.exit_code == exit_code_of(ErrorCode::Invalid));
  CHECK(named.err.find("--truth scores frames that are named by their number alone") != std::string::npos);
  CHECK_FALSE(fs::exists(out));
  REQUIRE(scored(out + "/%06d.exr", {}).exit_code == 0);
  const std::string text = "not a frame of the second run";
  for (const char* file : {"/000004.exr", "/novel/000002.exr"}) {
    fs::create_directories(out + "/novel");
    require_done(write_whole(posix_storage(), out + file, std::as_bytes(std::span(text))));
  }
  const RanHere fewer = scored(out + "/%06d.exr", {"--frames", "4", "--force"});
  INFO(fewer.err);
  CHECK(fewer.exit_code == 0);
  CHECK(text_of(out + "/000004.exr") == text);
}

TEST_CASE("a clip of another size is refused as the truth before the recording is replayed") {
  const std::string folder = sample::scratch_folder("replay_other_truth"), walk = folder + "/walk.mkv",
                    clip = folder + "/clip", out = folder + "/out";
  REQUIRE(ran_here({"simulate", "walk?size=32x32", "--frames", "6", "-o", walk}).exit_code == 0);
  REQUIRE(ran_here({"simulate", "walk?size=64x48", "--frames", "6", "--truth", clip}).exit_code == 0);
  const RanHere refused =
      ran_here({"replay", walk, "--preset", "fast", "--truth", clip, "-o", out + "/%06d.exr"});
  INFO(refused.err);
  CHECK(refused.exit_code == exit_code_of(ErrorCode::SizeChanged));
  CHECK(refused.err.find("/clip' has 64x48 pixels and the recording 32x32") != std::string::npos);
  CHECK_FALSE(fs::exists(out + "/000000.exr"));
}

// Makes a recording and its clip, whose frame 5 has a novel view: that of its own camera.
void simulate_novel_view(const std::string& recording, const std::string& clip) {
  REQUIRE(ran_here({"simulate", "walk?size=32x32", "--frames", "6", "-o", recording, "--truth", clip})
              .exit_code == 0);
  const std::string facts = clip + "/gt/gt.json";
  auto truth = nlohmann::json::parse(text_of(facts));
  truth["frames"][5]["novel_c2w"] = truth["frames"][5]["c2w"];
  test::write_file(facts, truth.dump());
  fs::create_directories(clip + "/gt/novel");
  fs::copy_file(clip + "/gt/hdr/0005.exr", clip + "/gt/novel/0005.exr");
}

TEST_CASE("novel views are compressed as the frames are") {
  const std::string folder = sample::scratch_folder("replay_novel"), walk = folder + "/walk.mkv",
                    clip = folder + "/clip";
  simulate_novel_view(walk, clip);
  for (const std::string compression : {"none", "zip"}) {
    const std::string out = folder + "/" + compression;
    const RanHere ended = ran_here({"replay", walk, "--preset", "fast", "--truth", clip, "--compression",
                                    compression, "-o", out + "/%06d.exr"});
    INFO(ended.err);
    REQUIRE(ended.exit_code == 0);
    for (const std::string file : {"/000005.exr", "/novel/000005.exr"}) {
      const std::string name("compression\0compression\0", 24);
      constexpr std::size_t kSize = 4;  // before the value, which is a byte
      const std::string bytes = text_of(out + file);
      const auto at = bytes.find(name);
      REQUIRE(at != std::string::npos);
      CHECK(int{bytes.at(at + name.size() + kSize)} == (compression == "none" ? 0 : 3));
    }
  }
}

TEST_CASE("novel views of an earlier replay stay without --force") {
  const std::string folder = sample::scratch_folder("replay_novel_kept"), walk = folder + "/walk.mkv",
                    clip = folder + "/clip", view = folder + "/out/novel/000009.exr";
  simulate_novel_view(walk, clip);
  fs::create_directories(folder + "/out/novel");
  test::write_file(view, "an earlier view");
  std::vector<std::string> words{"replay", walk, "--preset", "fast", "--truth", clip, "-o"};
  words.push_back(folder + "/out/%06d.exr");
  const RanHere refused = ran_here(words);
  INFO(refused.err);
  CHECK(refused.exit_code == exit_code_of(ErrorCode::Exists));
  CHECK(refused.err.find(fmt::format("would mix with 1 earlier file, '{}' among them", view)) !=
        std::string::npos);
  words.push_back("--force");
  const test::Ran forced = test::ran(words);
  INFO(forced.output);
  CHECK(forced.exit_code == 0);
  CHECK(forced.output.find("1 file of an earlier run remains beside the new ones") != std::string::npos);
  CHECK(text_of(view) == "an earlier view");
  CHECK(fs::exists(folder + "/out/novel/000005.exr"));
}

TEST_CASE("novel views have the white balance of the frames beside which they are scored") {
  const std::string folder = sample::scratch_folder("replay_novel_white"), walk = folder + "/walk.mkv",
                    clip = folder + "/clip";
  simulate_novel_view(walk, clip);
  const auto red = [&](const std::string& balance) {
    const std::string out = folder + "/" + balance.substr(0, 1);
    const RanHere ended = ran_here({"replay", walk, "--preset", "fast", "--truth", clip, "--white-balance",
                                    balance, "-o", out + "/%06d.exr"});
    INFO(ended.err);
    REQUIRE(ended.exit_code == 0);
    const ExrImage view = read_exr(posix_storage(), out + "/novel/000005.exr").value();
    const auto at = [&](const char* name) { return view.samples.at(view.find(name).value(), 16, 16); };
    return std::pair(at("R"), at("G"));
  };
  const auto plain = red("1,1,1"), balanced = red("4,1,1");
  REQUIRE(plain.first > 0);
  CHECK(balanced.first / plain.first == Approx(4).epsilon(0.01));
  CHECK(balanced.second == plain.second);
}
