// What no output of a verb may destroy, what a refused or failed run leaves, and what it says that it wrote.
#include <algorithm>
#include <filesystem>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "firmware_host/exit_code.h"
#include "firmware_host/web/http_server.h"
#include "hal/recording/image_sequence.h"
#include "render/exr.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/ran_here.h"

#include "tests/support/files.h"
#include "tests/support/ran.h"

using namespace hdrcam;
using Catch::Contains;
using test::ran_here;
using test::RanHere;
using test::text_of;

namespace {

namespace fs = std::filesystem;

const std::string kDemo = HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";
const std::vector<std::string> kQuick{"--preset", "fast", "--emit", "state"};

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void put(const std::string& path, const std::string& text) {
  require_done(write_whole(posix_storage(), path, std::as_bytes(std::span(text))));
}

bool has_line(const std::string& text, const std::string& wanted) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line == wanted) return true;
  return false;
}

}  // namespace

TEST_CASE("no output takes the place of the configuration, of a clip or of its truth, even with --force") {
  const std::string folder = sample::scratch_folder("kept_inputs"), clip = folder + "/clip",
                    walk = folder + "/walk.mkv", config = folder + "/c.toml", odd = folder + "/c.mkv",
                    out = folder + "/out";
  REQUIRE(ran_here({"simulate", "walk?size=32x32", "--frames", "6", "-o", walk, "--truth", clip}).exit_code ==
          0);
  for (const std::string& file : {config, odd}) put(file, "[fit]\nseed = 2\n");
  const auto refused = [&](const std::vector<std::string>& words, const char* kept) {
    const RanHere run = ran_here(words);
    INFO(run.err);
    CHECK(run.exit_code == 2);
    CHECK_THAT(run.err, Contains("would overwrite") && Contains(kept));
  };
  const char* const kConfig = "the configuration";
  refused({"replay", walk, "--config", config, "--stats", config}, kConfig);
  refused({"live", "--camera", "sim:still?size=32x32", "--config", config, "--report", config}, kConfig);
  refused({"record", "--camera", "sim:still?size=32x32", "--config", odd, "--force", "-o", odd}, kConfig);
  refused({"simulate", "walk?size=32x32", "--config", odd, "--force", "-o", odd}, kConfig);
  refused({"compare", clip, out, "--config", config, "--json", config}, kConfig);
  for (const std::string& file : {config, odd}) CHECK(text_of(file) == "[fit]\nseed = 2\n");

  const std::string clip_json = text_of(clip + "/clip.json");
  refused({"compare", clip, out, "--json", clip + "/clip.json"}, "the clip");
  refused({"replay", walk, "--truth", clip, "--force", "-o", clip + "/gt/hdr/%04d.exr"}, "the ground truth");
  refused({"replay", walk, "--truth", clip, "--force", "-o", out + "/%06d.exr", "--preview",
           clip + "/ldr/%04d.png"},
          "the pictures of the clip");
  CHECK(text_of(clip + "/clip.json") == clip_json);
  CHECK(value_of(ImageSequence::open(posix_storage(), clip)).frame_count() == 6);
  CHECK_FALSE(fs::exists(out));
}

TEST_CASE("what may be no recording is not called one where an output would overwrite it") {
  const std::string notes = sample::scratch_folder("kept_notes") + "/notes.txt";
  put(notes, "no recording");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"replay", notes}, {"live", "--camera", "replay:" + notes}}) {
    const RanHere run = ran_here(joined(words, {"--stats", notes}));
    CHECK(run.exit_code == 2);
    CHECK_THAT(run.err, Contains("would overwrite the file that is read '" + notes + "'"));
  }
  CHECK(text_of(notes) == "no recording");
}

TEST_CASE("a file of settings that names outputs of other verbs stops no verb, and nothing is made of them") {
  const std::string folder = sample::scratch_folder("kept_shared"), walk = folder + "/walk.mkv",
                    frames = folder + "/frames/%06d.exr", video = folder + "/earlier.mp4",
                    config = folder + "/c.toml";
  REQUIRE(ran_here({"simulate", "walk?size=64x48", "--frames", "6", "-o", walk}).exit_code == 0);
  const std::string recorded = text_of(walk);
  put(video, "an earlier video");
  const auto done = [&](const std::vector<std::string>& words, const std::string& settings) {
    put(config, settings);
    const RanHere run = ran_here(joined(words, {"--config", config}));
    INFO(run.err);
    CHECK(run.exit_code == 0);
  };
  const auto recording = [&](const std::string& file) { return "[record]\nfile = \"" + file + "\"\n"; };
  done(joined({"replay", walk, "-o", frames}, kQuick), recording(walk));
  done(joined({"render", walk, "-o", folder + "/film/%06d.exr"}, kQuick), recording(walk));
  done(joined({"replay", walk, "-o", folder + "/again/%06d.exr"}, kQuick), recording(folder + "/none/t.mkv"));
  const std::string outputs = "[output]\nframes = \"" + frames + "\"\nvideo = \"" + video + "\"\nstats = \"" +
                              folder + "/none/stats.json\"\n";
  done({"encode", frames, "-o", folder + "/new.mp4"}, recording(walk) + outputs);
  done({"record", "--camera", "sim:still?size=64x48", "--frames", "2", "-o", folder + "/new.mkv"}, outputs);
  CHECK(text_of(walk) == recorded);
  CHECK(text_of(video) == "an earlier video");
  CHECK_FALSE(fs::exists(folder + "/none"));
}

TEST_CASE("an empty name of a file or a folder is refused by every verb and every flag") {
  const std::vector<std::vector<std::string>> lines{{"export", kDemo, "-o", ""},
                                                    {"export", "", "-o", "out"},
                                                    {"compare", "", ""},
                                                    {"compare", "clip", "out", "--json", ""},
                                                    {"info", ""},
                                                    {"repair", kDemo, "-o", ""},
                                                    {"import", "clip", "-o", ""},
                                                    {"simulate", "walk", "-o", ""},
                                                    {"simulate", "walk", "--truth", ""},
                                                    {"manual", "-o", ""},
                                                    {"bench", "pareto", "clip", "-o", ""},
                                                    {"bench", "kernels", "--json", ""},
                                                    {"calibrate", "delay", "-o", ""},
                                                    {"record", "-o", ""},
                                                    {"record", "--trace", "", "-o", "x.mkv"},
                                                    {"encode", "out/%06d.exr", "-o", ""},
                                                    {"encode", "", "-o", "x.mp4"},
                                                    {"replay", kDemo, "-o", ""},
                                                    {"replay", kDemo, "-o", "out/%06d.exr", "--stats", ""},
                                                    {"replay", kDemo, "-o", "out/%06d.exr", "--truth", ""},
                                                    {"replay", kDemo, "-o", "out/%06d.exr", "--config", ""},
                                                    {"render", kDemo, "-o", "out/%06d.exr", "--path", ""},
                                                    {"live", "--camera", "sim:still", "--record", ""}};
  for (const auto& line : lines) {
    INFO(line.front() << " " << line[line.size() - 2]);
    const RanHere run = ran_here(line);
    CHECK(run.exit_code == 2);
    CHECK_THAT(run.err, Contains("takes the name of a file or a folder, not ''"));
  }
}

TEST_CASE("no verb makes a folder for the standard output") {
  const std::vector<std::vector<std::string>> lines{{"export", kDemo, "-o", "-"},
                                                    {"simulate", "walk", "--truth", "-"},
                                                    {"manual", "-o", "-"},
                                                    {"bench", "pareto", "clip", "-o", "-"}};
  for (const auto& line : lines) {
    INFO(line.front());
    const RanHere run = ran_here(line);
    CHECK(run.exit_code == 2);
    CHECK_THAT(run.err, Contains("takes the name of a folder, not '-', the standard output"));
    CHECK_FALSE(fs::exists("./-"));
  }
}

TEST_CASE("a run that is refused leaves no folder of its outputs") {
  const std::string folder = sample::scratch_folder("kept_refused"), out = folder + "/out";
  for (const std::vector<std::string>& flags :
       std::vector<std::vector<std::string>>{{"-o", out + "/%06d/%06d.exr"},
                                             {"-o", out + "/frame.exr"},
                                             {"--preview", out + "/%06d.exr"},
                                             {"--colmap", out + "/colmap"},
                                             {"--transforms", out + "/transforms.json"},
                                             {"--flow-forward", out + "/%06d.flo", "--lookahead", "0"},
                                             {"--http", "localhost", "-o", out + "/%06d.exr"},
                                             {"--stats", out + "/"}}) {
    INFO(flags.back());
    CHECK(ran_here(joined({"replay", kDemo}, flags)).exit_code == 2);
    CHECK_FALSE(fs::exists(out));
  }
  const std::string frames = out + "/%06d.exr";
  for (const std::vector<std::string>& flags :
       std::vector<std::vector<std::string>>{{"--http", "localhost"},
                                             {"--control-delay", "soon"},
                                             {"--trigger-line", "sim", "--trigger", "off"},
                                             {"--trigger-line", "sim", "--trigger-width", "0"}}) {
    INFO(flags.front());
    CHECK(ran_here(joined({"live", "--camera", "sim:walk?size=64x48", "--frames", "2", "-o", frames}, flags))
              .exit_code == 2);
    CHECK_FALSE(fs::exists(out));
  }
  // what only the camera or the recording tells
  const std::string camera = "sim:walk?size=64x48", deep = out + "/of/today/%06d.exr";
  for (const auto& [words, error] : std::vector<std::pair<std::vector<std::string>, ErrorCode>>{
           {{"live", "--camera", "sim:nowhere", "--frames", "2", "-o", deep}, ErrorCode::NotFound},
           {{"live", "--camera", camera, "--shutter", "900s", "--frames", "2", "-o", deep},
            ErrorCode::BadExposure},
           {{"live", "--camera", camera, "--memory", "64", "--frames", "2", "-o", deep},
            ErrorCode::Unsupported},
           {{"record", "--camera", camera, "--shutter", "900s", "--frames", "2", "-o", out + "/walk.mkv"},
            ErrorCode::BadExposure},
           {{"replay", kDemo, "--memory", "64", "-o", deep}, ErrorCode::Unsupported}}) {
    INFO(words.front() << ' ' << words[3]);
    CHECK(ran_here(words).exit_code == exit_code_of(error));
    CHECK_FALSE(fs::exists(out));
  }
  fs::create_directories(out + "/of");  // which is not the run's
  CHECK(ran_here({"replay", kDemo, "--memory", "64", "-o", deep}).exit_code ==
        exit_code_of(ErrorCode::Unsupported));
  CHECK(fs::is_empty(out + "/of"));
  fs::remove_all(out);
  for (const char* verb : {"replay", "render"})
    CHECK_THAT(ran_here({verb, folder + "/none.mkv", "-o", frames}).err,
               Contains("none.mkv' does not exist"));
  CHECK_THAT(ran_here({"live", "--camera", "sim:walk", "--shutter", "1,4", "-o", frames}).err,
             Contains("has no unit"));
  CHECK_FALSE(fs::exists(out));
}

TEST_CASE("a run that fails leaves a link to a folder that is not there, as on a disk that is not mounted") {
  const std::string folder = sample::scratch_folder("kept_link"), link = folder + "/out";
  fs::create_directory_symlink(folder + "/disk/out", link);
  for (const std::string& frames : {link + "/%06d.exr", link + "/today/%06d.exr"}) {
    INFO(frames);
    CHECK(ran_here(joined({"replay", kDemo, "-o", frames}, kQuick)).exit_code != 0);
    CHECK(fs::is_symlink(link));
  }
}

TEST_CASE("a run that is refused leaves the earlier recording, even with --force, and makes none") {
  const std::string folder = sample::scratch_folder("kept_takes"), take = folder + "/take.mkv",
                    none = folder + "/none.mkv", wide = folder + "/wide.mkv";
  REQUIRE(ran_here({"simulate", "walk?size=640x480", "--frames", "1", "-o", wide}).exit_code == 0);
  put(take, "an earlier take");
  const auto server = value_of(HttpServer::open({"127.0.0.1", 0}, "token", {}, {}));
  const std::string port = to_text(server->address());
  const auto refused = [&](std::vector<std::string> words, int exit_code) {
    words.insert(words.begin(), "live");
    const RanHere forced = ran_here(joined(words, {"--record", take, "--force"}));
    INFO(forced.err);
    CHECK(forced.exit_code == exit_code);
    CHECK(text_of(take) == "an earlier take");
    CHECK(ran_here(joined(words, {"--record", none})).exit_code == exit_code);
    CHECK_FALSE(fs::exists(none));
  };
  refused({"--camera", "sim:still?size=64x48", "--http", port}, 13);
  refused({"--camera", "replay:" + kDemo, "--http", port}, 13);
  refused({"--camera", "replay:" + wide, "--memory", "64"}, 16);
}

TEST_CASE("no page, sheet, list or snapshot takes the place of a recording or a video, even with --force") {
  const std::string folder = sample::scratch_folder("kept_from_pages");
  for (const char* name : {"/take.mkv", "/film.mp4", "/film.mov"}) {
    const std::string kept = folder + name;
    put(kept, "an earlier take");
    for (const char* flag : {"--stats", "--report", "--sheet", "--transforms", "--snapshot"}) {
      INFO(flag << " " << name);
      const RanHere run = ran_here(
          {"replay", kDemo, "-o", folder + "/out/%06d.exr", "--preset", "fast", "--force", flag, kept});
      CHECK(run.exit_code == 2);
      CHECK_THAT(run.err, Contains("would replace a picture or a recording"));
      CHECK(text_of(kept) == "an earlier take");
    }
  }
}

TEST_CASE("an earlier list of frames stays without --force, also where the frames are named otherwise") {
  const std::string folder = sample::scratch_folder("kept_frame_list"), list = folder + "/frames.csv";
  put(list, "an earlier list");
  const std::vector<std::string> words =
      joined({"replay", kDemo, "--frames", "6", "-o", folder + "/%06d_b.exr"}, kQuick);
  const RanHere run = ran_here(words);
  CHECK(run.exit_code == exit_code_of(ErrorCode::Exists));
  CHECK_THAT(run.err,
             Contains("the list beside --output '" + list + "' exists already") && Contains("--force"));
  CHECK(text_of(list) == "an earlier list");
  CHECK(ran_here(joined(words, {"--force"})).exit_code == 0);
  CHECK_THAT(text_of(list), Contains("_b.exr"));
}

TEST_CASE("poses for other tools stay without --force, whoever made them") {
  const std::string folder = sample::scratch_folder("kept_poses"), transforms = folder + "/transforms.json",
                    points = folder + "/points3D.txt";
  put(transforms, "poses of another program");
  put(points, "points of another program");
  for (const auto& [flag, path] : {std::pair("--transforms", transforms), {"--colmap", folder}}) {
    INFO(flag);
    const RanHere run =
        ran_here({"replay", kDemo, "--preset", "fast", "--preview", folder + "/new/%06d.png", flag, path});
    CHECK(run.exit_code == exit_code_of(ErrorCode::Exists));
    CHECK_THAT(run.err, Contains(flag) && Contains("--force"));
  }
  CHECK(text_of(transforms) == "poses of another program");
  CHECK(text_of(points) == "points of another program");
}

TEST_CASE("a video that holds no frame is not left, and an earlier one stays") {
  const std::string folder = sample::scratch_folder("kept_video"), video = folder + "/depth.mp4";
  constexpr int kSide = 16;  // codecs take no smaller ones
  const std::vector<float> depth(std::size_t{kSide} * kSide, 1.f);
  ExrPicture picture;
  picture.rows = picture.cols = kSide;
  picture.channels.push_back({"Z", depth, ExrSample::Float});
  require_done(write_whole(posix_storage(), folder + "/000000.exr", value_of(encode_exr(picture))));
  const std::vector<std::string> words{"encode", folder + "/%06d.exr", "--force", "-o", video};
  const RanHere none = ran_here(words);
  CHECK(none.exit_code == exit_code_of(ErrorCode::Unsupported));  // as compare says of such files
  CHECK_THAT(none.err, Contains("has no channel"));
  CHECK_FALSE(fs::exists(video));
  put(video, "an earlier video");
  CHECK(ran_here(words).exit_code == exit_code_of(ErrorCode::Unsupported));
  CHECK(text_of(video) == "an earlier video");
}

TEST_CASE("a run lists the outputs that it completed, and no other") {
  const std::string folder = sample::scratch_folder("kept_list"), frames = folder + "/%06d.exr",
                    report = folder + "/report.html", trace = folder + "/trace.json";
  const test::Ran run = test::ran(joined({"replay", kDemo, "--frames", "6", "-o", frames, "--stats",
                                          "/dev/full", "--report", report, "--trace", trace},
                                         kQuick));
  INFO(run.output);
  CHECK(run.exit_code == 11);
  CHECK_FALSE(has_line(run.output, "/dev/full"));
  CHECK_THAT(run.output,
             Contains(frames + ": 6 frames\n") && Contains(report + "\n") && Contains(trace + "\n"));
  CHECK(fs::exists(report));  // written, although the statistics before it failed
}

TEST_CASE("a run with --force says which files of an earlier, longer run remain beside its own") {
  const std::string folder = sample::scratch_folder("kept_older"), frames = folder + "/%06d.exr";
  const auto replayed = [&](const char* count) {
    const test::Ran run =
        test::ran(joined({"replay", kDemo, "--force", "--frames", count, "-o", frames}, kQuick));
    INFO(run.output);
    CHECK(run.exit_code == 0);
    return run.output;
  };
  CHECK_THAT(replayed("8"), !Contains("earlier run"));
  CHECK_THAT(replayed("6"), Contains("warning: 2 files of an earlier run remain") && Contains(frames));
  CHECK_THAT(replayed("8"), !Contains("earlier run"));
}
