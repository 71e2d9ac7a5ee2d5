// A scene that a run saved, from outside: the film of it is the film of the run, and what cannot be is said.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "firmware_host/exit_code.h"
#include "hal/forwarding_storage.h"
#include "hal/recording/recording.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/moving_scene.h"
#include "tests/support/ran_here.h"
#include "tests/support/stopping_storage.h"

#include "tests/support/files.h"
#include "tests/support/ran.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::ran_here;
using test::RanHere;
using test::text_of;
using test::write_file;
namespace fs = std::filesystem;

namespace {

constexpr int kFrames = 9;

// A recording, and the scene that a replay of it saved, made once.
struct Saved {
  std::string folder = sample::scratch_folder("snapshot_saved"), clip = folder + "/clip.mkv",
              scene = folder + "/clip.hdrscene";
  std::string told;  // of the replay

  Saved() {
    const test::MovingScene moving;
    auto writer = create_recording(posix_storage(), clip, moving.camera()).value();
    for (int i = 0; i < kFrames; ++i) REQUIRE(writer->append(moving.frame(i)).ok());
    REQUIRE(writer->finish().ok());
    const test::Ran run = test::ran(
        {"replay", clip, "--preset", "fast", "--set", "steps=2", "--threads", "2", "--snapshot", scene});
    INFO(run.output);
    REQUIRE(run.exit_code == 0);
    told = run.output;
  }
};
const Saved& saved() {
  static const Saved once;
  return once;
}

// Each frame's file, in order, byte by byte.
std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> paths, texts;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() != ".csv") paths.push_back(entry.path().string());
  std::ranges::sort(paths);
  for (const std::string& path : paths) texts.push_back(text_of(path));
  return texts;
}

std::vector<std::string> film(const std::string& of, const std::string& name, std::vector<std::string> flags,
                              const char* extension) {
  const std::string folder = sample::scratch_folder("snapshot_film_" + name);
  std::vector<std::string> words{"render", of, "-o", folder + "/%06d" + extension};
  words.insert(words.end(), flags.begin(), flags.end());
  const RanHere run = ran_here(words);
  INFO(run.err);
  REQUIRE(run.exit_code == 0);
  return files_in(folder);
}

// Whether the film of the snapshot has the files of the film of the recording.
void check_same(const std::string& name, const std::vector<std::string>& flags,
                const char* extension = ".exr") {
  std::vector<std::string> fitted = flags;
  for (const char* word : {"--preset", "fast", "--set", "steps=2"}) fitted.emplace_back(word);
  const auto of_recording = film(saved().clip, name + "_recording", fitted, extension);
  const auto of_snapshot = film(saved().scene, name + "_snapshot", flags, extension);
  INFO(name);
  CHECK(of_recording.size() == of_snapshot.size());
  CHECK(of_recording == of_snapshot);
}

RanHere refused(const std::vector<std::string>& words, ErrorCode code = ErrorCode::Invalid) {
  const RanHere run = ran_here(words);
  INFO(run.err);
  CHECK(run.exit_code == exit_code_of(code));
  return run;
}

}  // namespace

TEST_CASE("a film of a run's last moment is the same from its snapshot as from the recording, byte by byte",
          "[film]") {
  const std::string last = "0.2666666";  // of the ninth frame
  check_same("view", {"--time", last, "--view", "0.2,0,0,7,0,0", "--layers", "provenance,depth"});
  check_same("place", {"--time", last});
  check_same("before", {"--time", "0.25", "--view", "0,0.1,-0.1"});  // between the last two frames
  check_same("blurred", {"--time", "0.25", "--view", "0.1,0,0", "--shutter-angle", "90"});
  check_same("steady", {"--time", last, "--stabilize"});
  check_same("stereo", {"--time", last, "--stereo", "0.2", "--size", "96x48"});
  check_same("ldr", {"--time", last, "--view", "0.2,0,0", "--exposure", "4ms"}, ".png");
}

TEST_CASE("from the recorded camera the snapshot's whole span is filmed as from the recording, byte by byte",
          "[film]") {
  check_same("span", {"--time", "0.1..0.2666666"});
  check_same("slow", {"--time", "0.1..0.2666666", "--speed", "0.3"});
  CHECK(film(saved().scene, "all", {}, ".exr").size() == 6);  // of the field's window
}

TEST_CASE("a run says where it saved its scene, and info what is in it", "[film]") {
  CHECK_THAT(saved().told, Contains("clip.hdrscene: the scene of the last 6 frames"));
  const test::Ran table = test::ran({"info", saved().scene});
  CHECK(table.exit_code == 0);
  for (const char* line : {"a snapshot of a scene", "64x48", "6, number 3 to 8",
                           "0.1 to 0.266667 s of the run", "tracked", "median depth of the first view"})
    CHECK_THAT(table.output, Contains(line));
  const auto json = nlohmann::json::parse(test::ran({"info", "--json", saved().scene}).output);
  CHECK(json.at("frames").size() == 6);
  CHECK(json.at("frames").at(5).at("sequence") == 8);
  CHECK(json.at("field") == true);
  CHECK(json.at("bytes") == fs::file_size(saved().scene));
}

TEST_CASE("a snapshot is known by its content, and what only has its name is not one", "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_named"), other = folder + "/scene.bin",
                    fake = folder + "/fake.hdrscene", out = folder + "/out/%06d.exr";
  fs::copy_file(saved().scene, other);
  CHECK(ran_here({"render", other, "--time", "0.2", "-o", out}).exit_code == 0);
  CHECK(ran_here({"info", other}).exit_code == 0);
  write_file(fake, "no scene");
  refused({"render", fake, "--force", "-o", out}, ErrorCode::NotRecording);
  refused({"info", fake}, ErrorCode::NotRecording);
  refused({"render", folder + "/none.hdrscene", "-o", out}, ErrorCode::NotFound);
  for (const char* verb : {"replay", "render"})
    CHECK_THAT(refused({verb, folder, "-o", folder + "/none/%06d.exr"}, ErrorCode::NotRecording).err,
               Contains("is a folder"));
  CHECK_THAT(refused({"info", folder}, ErrorCode::NotRecording).err, Contains("is a folder"));
}

TEST_CASE("every verb that reads a recording says of a snapshot that it is one, and makes no folder",
          "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_no_recording"), scene = folder + "/scene.mkv",
                    camera = "replay:" + scene, out = folder + "/out";
  fs::copy_file(saved().scene, scene);
  fs::copy_file(saved().clip, folder + "/still.jpg");
  const std::vector<std::vector<std::string>> verbs{
      {"replay", scene, "-o", out + "/%06d.exr"},
      {"repair", scene, "-o", out + "/whole.mkv"},
      {"export", scene, "-o", out},
      {"export", scene, "-o", out, "--transforms"},
      {"import", scene, "-o", out + "/walk.mkv"},
      {"import", folder + "/still.jpg", scene, "-o", out + "/walk.mkv"},
      {"import", scene, "--list", "--shutter", "1ms,4ms"},
      {"live", "--camera", camera, "-o", out + "/%06d.exr"},
      {"live", "--camera", camera, "--pace", "realtime", "-o", out + "/%06d.exr"},
      {"record", "--camera", camera, "-o", out + "/copy.mkv"},
      {"record", "--camera", camera, "--pace", "realtime", "-o", out + "/copy.mkv"},
      {"calibrate", "delay", "--camera", camera, "-o", out + "/camera.toml"}};
  for (const std::vector<std::string>& words : verbs) {
    INFO(words.front() << ' ' << words[1]);
    CHECK(refused(words, ErrorCode::NotRecording).err ==
          "hdrcam: '" + scene + "' is a snapshot of a scene, not a recording; 'hdrcam render' films it.\n");
    CHECK_FALSE(fs::exists(out));
  }
}

TEST_CASE("a damaged or cut snapshot is one sentence of render and of info, and leaves no film", "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_damaged"), bad = folder + "/bad.hdrscene",
                    whole = text_of(saved().scene);
  const auto told = [&](const std::string& text, ErrorCode code) {
    write_file(bad, text);
    for (const RanHere& run :
         {refused({"render", bad, "-o", folder + "/out/%06d.exr"}, code), refused({"info", bad}, code)}) {
      CHECK_THAT(run.err, Contains("bad.hdrscene'"));
      CHECK(std::ranges::count(run.err, '\n') == 1);
    }
    CHECK((!fs::exists(folder + "/out") || files_in(folder + "/out").empty()));
  };
  std::string damaged = whole;
  damaged[whole.size() / 2] ^= 16;
  told(damaged, ErrorCode::Corrupt);
  told(whole.substr(0, whole.size() / 2), ErrorCode::Truncated);
  std::string newer = whole;
  newer[8] = 9;
  told(newer, ErrorCode::Unsupported);
}

TEST_CASE("flags of a fit, and moments and lengths that a snapshot has not, are refused", "[film]") {
  const std::string& scene = saved().scene;
  const std::string folder = sample::scratch_folder("snapshot_refused"), out = folder + "/x/%06d.exr";
  const auto told = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"render", scene, "-o", out});
    return refused(flags).err;
  };
  CHECK_THAT(told({"--preset", "fast", "--set", "steps=1", "--seed", "2"}),
             Contains("is fitted already; leave out") && Contains("--preset") && Contains("--set") &&
                 Contains("--seed"));
  CHECK_THAT(told({"--time", "0.05"}), Contains("outside the snapshot, which spans 0.1 to 0.266667 s"));
  CHECK_THAT(told({"--stereo", "63mm"}), Contains("the poses are tracked and have no metres"));
  CHECK_THAT(told({"--layers", "flow"}), Contains("writes the motion between recorded frames"));
  CHECK_THAT(refused({"render", scene}).err, Contains("nothing to write"));
  CHECK_THAT(refused({"render", scene, "-o", out, "--snapshot", "s.hdrscene"}).err, Contains("--snapshot"));
  CHECK_FALSE(fs::exists(folder + "/x"));
  CHECK(ran_here({"render", scene, "-o", out, "--threads", "1", "--time", "0.2"}).exit_code == 0);
}

TEST_CASE("a snapshot takes the place of an earlier one with --force only, and of no input", "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_kept"), scene = folder + "/s.hdrscene";
  write_file(scene, "an earlier scene");
  std::vector<std::string> words{"replay", saved().clip, "--preset", "fast", "--snapshot", scene};
  CHECK_THAT(refused(words, ErrorCode::Exists).err, Contains("--snapshot") && Contains("--force"));
  CHECK(text_of(scene) == "an earlier scene");
  words.back() = "-";
  CHECK_THAT(refused(words).err, Contains("--snapshot - would write a file named '-'"));
  words.back() = saved().clip;
  words.emplace_back("--force");
  CHECK_THAT(refused(words).err, Contains("would overwrite the file that is read"));
  CHECK_THAT(refused({"render", saved().scene, "--force", "-o", saved().folder + "/%06d.exr", "--stats",
                      saved().scene})
                 .err,
             Contains("would overwrite the snapshot that is read"));
  CHECK_THAT(refused({"replay", saved().clip, "-o", folder + "/%06d.exr", "--stats", scene}).err,
             Contains("would replace a saved scene"));
  words = {"replay", saved().clip, "--preset", "fast", "--snapshot", scene, "--force"};
  CHECK(ran_here(words).exit_code == 0);
  CHECK(ran_here({"info", scene}).exit_code == 0);
}

TEST_CASE("a scene that another program saved during the run stays, and so does that of the run", "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_of_another"), scene = folder + "/s.hdrscene";
  // With the first frame of the run the other program writes its scene.
  class Shared : public ForwardingStorage {
   public:
    explicit Shared(std::string path) : ForwardingStorage(posix_storage()), path_(std::move(path)) {}
    Result<void> rename(const std::string& from, const std::string& to, Creation how) override {
      if (to.ends_with(".exr") && !fs::exists(path_)) write_file(path_, "another scene");
      return ForwardingStorage::rename(from, to, how);
    }

   private:
    const std::string path_;
  } shared(scene);
  const RanHere run = ran_here(
      {"replay", saved().clip, "--emit", "state", "-o", folder + "/%06d.exr", "--snapshot", scene}, shared);
  CHECK(run.exit_code == exit_code_of(ErrorCode::Exists));
  CHECK_THAT(run.err, Contains("was written by another program meanwhile"));
  CHECK(text_of(scene) == "another scene");
  CHECK(sample::unfinished_files_in(folder) == 1);
}

TEST_CASE("a run without a field saves a scene that is filmed from its own camera only", "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_state"), scene = folder + "/s.hdrscene",
                    out = folder + "/out/%06d.exr";
  REQUIRE(ran_here({"replay", saved().clip, "--emit", "state", "--snapshot", scene}).exit_code == 0);
  CHECK_THAT(refused({"render", scene, "-o", out, "--view", "0.1,0,0"}).err,
             Contains("the snapshot was saved without one"));
  CHECK_THAT(refused({"render", scene, "-o", out, "--layers", "depth"}).err,
             Contains("the snapshot was saved without one"));
  for (const char* flag : {"--transforms", "--colmap"})
    CHECK_THAT(refused({"render", scene, "-o", out, flag, folder + "/poses"}).err,
               Contains(std::string(flag) + " needs poses, and no frame of the snapshot has one"));
  CHECK_FALSE(fs::exists(folder + "/out"));
  CHECK(ran_here({"render", scene, "-o", out}).exit_code == 0);
  CHECK(files_in(folder + "/out").size() == 6);
}

TEST_CASE("what fails behind a film of a snapshot that is stopped is told, and not that it was stopped",
          "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_stopped");
  for (const bool full : {false, true}) {
    test::StoppingStorage storage(".exr", 2);
    const RanHere run = ran_here({"render", saved().scene, "--time", "0.1..0.2666666", "--speed", "0.01",
                                  "-o", folder + (full ? "/full/%06d.exr" : "/whole/%06d.exr"), "--stats",
                                  full ? "/dev/full" : folder + "/s.json"},
                                 storage, storage.stop());
    INFO(run.err);
    CHECK(run.exit_code == exit_code_of(full ? ErrorCode::NoSpace : ErrorCode::Interrupted));
    CHECK_THAT(run.err, Contains(full ? "hdrcam: no space left to write '/dev/full'" : "stopped after"));
  }
}

TEST_CASE("a scene of very small or very long pictures is filmed from its snapshot", "[film]") {
  struct Case {
    int rows, cols;
    const char* blocks;  // side of the field's
  };
  for (const Case& c : {Case{40, 4, "field_step=8"}, Case{2, 2048, "field_step=1"}}) {
    INFO(c.cols << "x" << c.rows);
    test::MovingScene moving;
    moving.rows = c.rows, moving.cols = c.cols;
    const std::string folder = sample::scratch_folder("snapshot_of_few_pixels");
    const std::string clip = folder + "/clip.mkv", scene = folder + "/clip.hdrscene";
    auto writer = create_recording(posix_storage(), clip, moving.camera()).value();
    for (int i = 0; i < 6; ++i) REQUIRE(writer->append(moving.frame(i)).ok());
    REQUIRE(writer->finish().ok());
    const RanHere run =
        ran_here({"replay", clip, "--preset", "fast", "--set", c.blocks, "--snapshot", scene});
    INFO(run.err);
    REQUIRE(run.exit_code == 0);
    const RanHere filmed = ran_here({"render", scene, "--time", "end", "-o", folder + "/%06d.exr"});
    INFO(filmed.err);
    CHECK(filmed.exit_code == 0);
    CHECK(fs::exists(folder + "/000000.exr"));
  }
}

TEST_CASE("a live run saves the scene of its end, and a run that is stopped before its first frame none",
          "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_live"), scene = folder + "/s.hdrscene";
  const std::vector<std::string> words{"live",       "--camera", "sim:walk?size=64x48", "--frames", "24",
                                       "--deadline", "off",      "--snapshot",          scene};
  const RanHere run = ran_here(words);
  INFO(run.err);
  REQUIRE(run.exit_code == 0);
  CHECK(ran_here({"info", scene}).exit_code == 0);
  CHECK(ran_here({"render", scene, "--view", "0.05,0,0", "-o", folder + "/out/%06d.exr"}).exit_code == 0);
  CHECK(ran_here({"replay", saved().clip, "--snapshot", folder + "/none.hdrscene"}, posix_storage(), true)
            .exit_code == kExitInterrupted);
  CHECK_FALSE(fs::exists(folder + "/none.hdrscene"));
}

TEST_CASE("a file of settings that names a snapshot makes one of replay and of no other verb", "[film]") {
  const std::string folder = sample::scratch_folder("snapshot_config"), scene = folder + "/{start}.hdrscene",
                    config = folder + "/c.toml";
  write_file(config, "[output]\nsnapshot = \"" + scene + "\"\n[fit]\nemit = \"state\"\n");
  const auto scenes = [&] {
    return std::ranges::count_if(fs::directory_iterator(folder),
                                 [](const auto& entry) { return entry.path().extension() == ".hdrscene"; });
  };
  CHECK(ran_here(
            {"render", saved().scene, "--config", config, "--view", "0.1,0,0", "-o", folder + "/a/%06d.exr"})
            .exit_code == 0);
  CHECK(ran_here({"record", "--camera", "sim:still?size=32x32", "--frames", "2", "--config", config, "-o",
                  folder + "/r.mkv"})
            .exit_code == 0);
  CHECK(scenes() == 0);
  CHECK(ran_here({"replay", saved().clip, "--config", config}).exit_code == 0);
  CHECK(scenes() == 1);
}

TEST_CASE("a file of settings that asks for motion gets a film without it", "[film]") {
  const std::string folder = sample::scratch_folder("film_config"), config = folder + "/c.toml";
  write_file(config,
             "[output]\nflow_forward = \"" + folder + "/flow/%06d.flo\"\nlayers = \"flow,confidence\"\n");
  std::vector<std::string> words{"render", saved().scene, "--config", config, "--time", "0.2"};
  CHECK_THAT(refused(words).err, Contains("nothing to write"));
  words.insert(words.end(), {"-o", folder + "/a/%06d.exr"});
  CHECK(ran_here(words).exit_code == 0);
  CHECK_FALSE(fs::exists(folder + "/flow"));
}
