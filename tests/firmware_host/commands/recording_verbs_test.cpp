// import, export and repair as the user calls them, and what info refuses.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "capture/recording_stage.h"
#include "firmware_host/commands/command.h"
#include "hal/fault/faulty_storage.h"
#include "hal/recording/image_sequence.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/ran.h"

#include "tests/support/files.h"

using namespace hdrcam;
using test::text_of;
using test::write_file;

namespace {

Result<void> hdrcam_verb(const std::string& line, Storage& storage = posix_storage(),
                         bool interrupted = false) {
  CLI::App app;
  Verb verb;
  add_import(app, verb);
  add_export(app, verb);
  add_info(app, verb);
  add_repair(app, verb);
  app.parse(line);
  const std::atomic<bool> stop = interrupted;
  Surroundings around{storage, stop};
  return verb(around);
}

// A clip whose images and facts are random but legal.
std::vector<RawFrame> write_clip(const std::string& folder, const CameraFacts& camera, int count) {
  auto frames = sample::frames(camera, count, 17);
  auto writer = ImageSequenceWriter::create(posix_storage(), folder, camera);
  REQUIRE(writer.ok());
  for (const RawFrame& frame : frames) REQUIRE(writer.value().append(frame).ok());
  REQUIRE(writer.value().finish().ok());
  return frames;
}

// Without what import finds in the pictures, which are random here and contradict any exposure.
RawFrame unjudged(const RawFrame& frame) {
  RawFrame bare{frame.facts, frame.codes.clone()};
  bare.facts.verdict.reset();
  bare.facts.exposure_within_ev.reset();
  bare.facts.flags &= ~std::uint32_t{kFrameExposureUnproved};
  return bare;
}

}  // namespace

TEST_CASE("exporting what was imported gives the clip, and importing that the same recording") {
  for (const auto layout : {PixelLayout::Rgb, PixelLayout::Mono, PixelLayout::BayerRggb})
    for (const int bits : {8, 12}) {
      const std::string folder = sample::scratch_folder("verbs");
      const auto frames = write_clip(folder + "/clip", sample::camera(layout, bits, 37, 23), 6);
      REQUIRE(hdrcam_verb("import " + folder + "/clip/clip.json -o " + folder + "/x.mkv").ok());
      CHECK(sample::unfinished_files_in(folder) == 0);
      const auto replayed = sample::replay(posix_storage(), folder + "/x.mkv");
      CHECK(!replayed.error);
      REQUIRE(replayed.frames.size() == 6);
      for (std::size_t i = 0; i < frames.size(); ++i)
        CHECK(sample::same(unjudged(replayed.frames[i]), unjudged(frames[i])));

      REQUIRE(hdrcam_verb("export " + folder + "/x.mkv -o " + folder + "/back").ok());
      for (int i = 0; i < 6; ++i) {
        const std::string file = fmt::format("/ldr/{:04}.png", i);
        CHECK(text_of(folder + "/back" + file) == text_of(folder + "/clip" + file));
      }
      REQUIRE(hdrcam_verb("import " + folder + "/back -o " + folder + "/y.mkv").ok());
      CHECK(text_of(folder + "/y.mkv") == text_of(folder + "/x.mkv"));
      REQUIRE(hdrcam_verb("export " + folder + "/y.mkv -o " + folder + "/again").ok());
      CHECK(text_of(folder + "/again/clip.json") == text_of(folder + "/back/clip.json"));
    }
}

TEST_CASE("a frame of unknown exposure leaves and comes back as one") {
  const std::string folder = sample::scratch_folder("unknown_exposure");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  auto frames = sample::frames(camera, 5, 2);
  FrameFacts& unknown = frames[2].facts;
  unknown.exposure_s = 0, unknown.exposure_source = ExposureSource::Unknown;
  unknown.verdict = Verdict::Unknown, unknown.flags |= kFrameExposureUnproved;
  REQUIRE(sample::record(posix_storage(), folder + "/x.mkv", camera, frames).ok());
  REQUIRE(hdrcam_verb("export " + folder + "/x.mkv -o " + folder + "/clip").ok());
  const auto clip = ImageSequence::open(posix_storage(), folder + "/clip");
  INFO(sample::error_of(clip).message);
  REQUIRE(clip.ok());
  for (int i = 0; i < 5; ++i)
    CHECK(sample::same(clip.value().facts(i), frames[static_cast<std::size_t>(i)].facts));
  CHECK(hdrcam_verb("import " + folder + "/clip -o " + folder + "/y.mkv").ok());
}

TEST_CASE("a name that the file system does not take is an error of its own, no bug") {
  const std::string folder = sample::scratch_folder("long_names"), name(300, 'n');
  std::filesystem::create_symlink("loop", folder + "/loop");
  for (const std::string& file : {name, folder + "/loop"})
    for (const std::string& footage : {file, file + " " + folder + "/b.mp4"}) {
      const auto imported = hdrcam_verb("import " + footage + " --list");
      INFO(sample::error_of(imported).message);
      CHECK(sample::error_of(imported).code == ErrorCode::Io);
    }
}

TEST_CASE("a failed import leaves neither a new output nor a changed old one") {
  const std::string folder = sample::scratch_folder("failed");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  write_clip(folder + "/clip", camera, 4);
  const std::string line = "import --force " + folder + "/clip -o " + folder + "/x.mkv";
  write_file(folder + "/x.mkv", "older");
  const auto untouched = [&] {
    CHECK(text_of(folder + "/x.mkv") == "older");
    CHECK(sample::unfinished_files_in(folder) == 0);
  };
  SECTION("the disk is full") {
    FaultyStorage disk(posix_storage(), {.space_bytes = 4000});
    CHECK(sample::error_of(hdrcam_verb(line, disk)).code == ErrorCode::NoSpace);
    untouched();
  }
  SECTION("the disk fails") {
    FaultyStorage disk(posix_storage(), {.failing_write = 3});
    CHECK(sample::error_of(hdrcam_verb(line, disk)).code == ErrorCode::Io);
    untouched();
  }
  SECTION("the third image is missing") {
    std::filesystem::remove(folder + "/clip/ldr/0002.png");
    const auto imported = hdrcam_verb(line);
    CHECK(sample::error_of(imported).code == ErrorCode::NotFound);
    CHECK(imported.error().message.find("frame 2") != std::string::npos);
    untouched();
  }
  SECTION("the user interrupts") {
    CHECK(sample::error_of(hdrcam_verb(line, posix_storage(), true)).code == ErrorCode::Interrupted);
    untouched();
  }
  SECTION("nobody said --force") {
    CHECK(sample::error_of(hdrcam_verb("import " + folder + "/clip -o " + folder + "/x.mkv")).code ==
          ErrorCode::Exists);
    untouched();
  }
  SECTION("the output is an image of the clip") {
    const std::string image = folder + "/clip/ldr/0001.png", before = text_of(image);
    CHECK(sample::error_of(hdrcam_verb("import --force " + folder + "/clip -o " + image)).code ==
          ErrorCode::Invalid);
    CHECK(text_of(image) == before);
  }
  SECTION("and a good one replaces it") {
    REQUIRE(hdrcam_verb(line).ok());
    CHECK(!sample::replay(posix_storage(), folder + "/x.mkv").error);
  }
}

TEST_CASE("export gives the whole frames of a cut or damaged recording and never mixes two clips") {
  const std::string folder = sample::scratch_folder("export");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto frames = sample::frames(camera, 5, 2);
  const std::string path = folder + "/x.mkv", line = "export " + path + " -o " + folder + "/out";
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto bytes = std::filesystem::file_size(path);
  SECTION("cut") {
    FaultyStorage disk(posix_storage(), {.cut_at_bytes = bytes * 3 / 5});
    const auto whole = sample::replay(disk, path).frames.size();
    REQUIRE((whole > 1 && whole < 5));
    const Error told = sample::error_of(hdrcam_verb(line, disk));
    CHECK(told.code == ErrorCode::Truncated);
    CHECK(told.message ==
          fmt::format("'{0}' was cut after {1} whole frames, or is still being written; 'hdrcam "
                      "repair {0} -o FILE' makes a complete recording of them",
                      path, whole));
    CHECK(ImageSequence::open(posix_storage(), folder + "/out").value().frame_count() ==
          static_cast<int>(whole));
  }
  SECTION("damaged") {
    FaultyStorage disk(posix_storage(), {.flipped_bits = {bytes * 4}});
    CHECK(sample::error_of(hdrcam_verb(line + " --strict", disk)).code == ErrorCode::Corrupt);
    CHECK(!std::filesystem::exists(folder + "/out/clip.json"));
    REQUIRE(hdrcam_verb(line + " --force", disk).ok());
    CHECK(ImageSequence::open(posix_storage(), folder + "/out").value().frame_count() == 4);
  }
  SECTION("damaged in all of its frames") {
    REQUIRE(hdrcam_verb(line).ok());
    const std::string worse = folder + "/worse.mkv";
    REQUIRE(sample::record(posix_storage(), worse, camera, sample::frames(camera, 1, 3)).ok());
    FaultyStorage disk(posix_storage(), {.flipped_bits = {std::filesystem::file_size(worse) * 4}});
    const auto none = hdrcam_verb("export " + worse + " -o " + folder + "/out --force", disk);
    CHECK(sample::error_of(none).code == ErrorCode::Corrupt);
    CHECK(none.error().message == "'" + worse + "' has no whole frame");
    CHECK(ImageSequence::open(posix_storage(), folder + "/out").value().frame_count() == 5);
  }
  SECTION("twice") {
    REQUIRE(hdrcam_verb(line).ok());
    const auto again = hdrcam_verb(line);
    CHECK(sample::error_of(again).code == ErrorCode::Exists);
    CHECK(again.error().message.find(folder + "/out") != std::string::npos);
    REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 2, 3)).ok());
    REQUIRE(hdrcam_verb(line + " --force").ok());
    CHECK(ImageSequence::open(posix_storage(), folder + "/out").value().frame_count() == 2);
  }
  SECTION("again, of fewer frames") {
    const auto exported = [&] {
      const test::Ran ran = test::ran(line + " --force");
      CHECK(ran.exit_code == 0);
      return ran.output;
    };
    CHECK(exported().find("earlier run") == std::string::npos);
    REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 2, 3)).ok());
    CHECK(exported().find("warning: 3 files of an earlier run remain") != std::string::npos);
  }
  SECTION("over pictures of the user's own") {
    const std::string mine = folder + "/out/ldr/0001.png", text = "my own picture";
    REQUIRE(posix_storage().make_directories(folder + "/out/ldr").ok());
    REQUIRE(write_whole(posix_storage(), mine, std::as_bytes(std::span(text))).ok());
    const auto refused = hdrcam_verb(line);
    CHECK(sample::error_of(refused).code == ErrorCode::Exists);
    CHECK(refused.error().message.find(mine) != std::string::npos);
    CHECK(read_whole(posix_storage(), mine).value() == text);
    CHECK(!std::filesystem::exists(folder + "/out/clip.json"));
  }
}

TEST_CASE("export does not call a recording that it cannot read one without poses") {
  const std::string folder = sample::scratch_folder("export_poses"), path = folder + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  auto frames = sample::frames(camera, 5, 2);
  for (RawFrame& frame : frames) frame.facts.T_world_camera.reset();
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto bytes = std::filesystem::file_size(path);
  const auto refused = [&](const std::string& flags, StorageFaults faults) {
    FaultyStorage disk(posix_storage(), std::move(faults));
    return sample::error_of(
        hdrcam_verb("export " + path + " -o " + folder + "/out --transforms" + flags, disk));
  };
  const StorageFaults damaged{.flipped_bits = {bytes * 4}}, cut{.cut_at_bytes = bytes * 3 / 5};
  CHECK(refused(" --strict", damaged).code == ErrorCode::Corrupt);
  CHECK(refused(" --strict", cut).code == ErrorCode::Truncated);
  for (const StorageFaults& faults : {damaged, cut}) {
    const Error none = refused("", faults);
    CHECK(none.code == ErrorCode::Invalid);
    CHECK(none.message.find("states no poses") != std::string::npos);
  }
  const auto stopped =
      hdrcam_verb("export " + path + " -o " + folder + "/out --transforms", posix_storage(), true);
  CHECK(sample::error_of(stopped).code == ErrorCode::Interrupted);
  CHECK_FALSE(std::filesystem::exists(folder + "/out"));

  const std::string spaced = folder + "/my walk.mkv";
  std::filesystem::copy_file(path, spaced);
  const test::Ran ran = test::ran({"export", spaced, "-o", folder + "/out", "--colmap"});
  CHECK(ran.output.find("hdrcam replay '" + spaced + "' --preview") != std::string::npos);
}

TEST_CASE("a verb that is stopped says what it has written") {
  const std::string folder = sample::scratch_folder("stopped_verbs"), path = folder + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 3, 2)).ok());
  const auto said = [&](const std::string& line) {
    return sample::error_of(hdrcam_verb(line, posix_storage(), true)).message;
  };
  CHECK(said("export " + path + " -o " + folder + "/out") == "stopped before the first frame");
  CHECK(said("repair " + path + " -o " + folder + "/r.mkv") == "stopped after 0 frames; nothing was written");
  CHECK_FALSE(std::filesystem::exists(folder + "/r.mkv"));
}

TEST_CASE("export of a single frame writes it, and says that it makes no clip that import takes") {
  const std::string folder = sample::scratch_folder("export_one"), path = folder + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  for (const int count : {1, 2}) {
    REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, count, 2)).ok());
    const test::Ran ran = test::ran({"export", path, "-o", folder + "/out", "--force"});
    CHECK(ran.exit_code == 0);
    CHECK(std::filesystem::exists(folder + "/out/ldr/0000.png"));
    const bool warned = ran.output.find("warning: a clip has at least 2 frames") != std::string::npos;
    CHECK(warned == (count == 1));
    const auto clip = ImageSequence::open(posix_storage(), folder + "/out");
    CHECK(clip.ok() == (count > 1));
  }
}

TEST_CASE("repair writes the whole frames of a cut or damaged recording, each with its number") {
  const std::string folder = sample::scratch_folder("repair");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto frames = sample::frames(camera, 6, 2);
  const std::string path = folder + "/x.mkv", repaired = folder + "/y.mkv";
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto bytes = std::filesystem::file_size(path);
  const auto line = "repair " + path + " -o " + repaired;
  SECTION("damaged") {
    FaultyStorage disk(posix_storage(), {.flipped_bits = {bytes * 4}});
    CHECK(sample::error_of(hdrcam_verb("info " + path, disk)).code == ErrorCode::Corrupt);
    const std::string spaced = folder + "/my walk.mkv";
    std::filesystem::copy_file(path, spaced);
    CHECK(sample::error_of(hdrcam_verb("info '" + spaced + "'", disk))
              .message.find("'hdrcam repair '" + spaced + "' -o FILE'") != std::string::npos);
    REQUIRE(hdrcam_verb(line, disk).ok());
    const auto whole = sample::replay(posix_storage(), repaired);
    CHECK_FALSE(whole.error);
    REQUIRE(whole.frames.size() == 5);
    std::size_t place = 0;
    for (const RawFrame& frame : whole.frames) {
      const bool after_gap = frame.facts.sequence != frames[place].facts.sequence;
      if (after_gap) ++place;
      CHECK(frame.facts.sequence == frames[place].facts.sequence);
      CHECK(sample::same(frame.codes, frames[place].codes));
      if (after_gap) CHECK((frame.facts.flags & kFrameAfterDrop) != 0);
      ++place;
    }
    CHECK(place == 6);
  }
  SECTION("cut") {
    FaultyStorage disk(posix_storage(), {.cut_at_bytes = bytes * 3 / 5});
    const Error info = sample::error_of(hdrcam_verb("info " + path, disk));
    CHECK(info.code == ErrorCode::Truncated);
    CHECK(info.message.ends_with("'hdrcam repair " + path + " -o FILE' makes a complete recording of them"));
    REQUIRE(hdrcam_verb(line, disk).ok());
    const auto whole = sample::replay(posix_storage(), repaired);
    CHECK_FALSE(whole.error);
    CHECK((whole.frames.size() > 1 && whole.is_start_of(frames)));
  }
  SECTION("onto itself") {
    CHECK(sample::error_of(hdrcam_verb("repair --force " + path + " -o " + path)).code == ErrorCode::Invalid);
    CHECK(sample::replay(posix_storage(), path).frames.size() == 6);
  }
  SECTION("without one whole frame") {
    write_file(path, text_of(path).substr(0, 900));
    CHECK_FALSE(hdrcam_verb(line).ok());
    CHECK_FALSE(std::filesystem::exists(repaired));
  }
  CHECK(sample::unfinished_files_in(folder) == 0);
}

TEST_CASE("whoever reads a recording is warned of another one behind it in the file") {
  const std::string folder = sample::scratch_folder("joined_verbs"), path = folder + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 5, 2)).ok());
  write_file(path, text_of(path) + text_of(path));
  for (const std::vector<std::string>& words : {std::vector<std::string>{"info", path},
                                                {"export", path, "-o", folder + "/out"},
                                                {"repair", path, "-o", folder + "/y.mkv"}}) {
    const test::Ran run = test::ran(words);
    INFO(words.front());
    CHECK(run.exit_code == 0);
    CHECK_THAT(run.output, Catch::Contains("warning: another recording, of "));
  }
  CHECK(sample::replay(posix_storage(), folder + "/y.mkv").frames.size() == 5);
  const auto stage = RecordingStage::open(posix_storage(), path, Contradiction::Warns).value();
  CHECK(std::ranges::any_of(stage->warnings(), [](const std::string& warning) {
    return warning.starts_with("another recording, of ");
  }));
}

TEST_CASE("a recording is named .mkv, so that no other program takes it for what it is not") {
  const std::string folder = sample::scratch_folder("recording_names");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  REQUIRE(sample::record(posix_storage(), folder + "/x.mkv", camera, sample::frames(camera, 3, 2)).ok());
  write_clip(folder + "/clip", camera, 3);
  for (const char* name : {"/y.mp4", "/y", "/y.mkv.part"})
    for (const std::string& verb : {"repair " + folder + "/x.mkv", "import " + folder + "/clip"}) {
      const Error refused = sample::error_of(hdrcam_verb(verb + " -o " + folder + name));
      CHECK(refused.code == ErrorCode::Invalid);
      CHECK(refused.message.find("is not the name of a recording") != std::string::npos);
      CHECK_FALSE(std::filesystem::exists(folder + name));
    }
  CHECK(hdrcam_verb("repair " + folder + "/x.mkv -o " + folder + "/y.MKV").ok());
}

TEST_CASE("a recording is one file, so its name has no number for each frame or take") {
  const std::string folder = sample::scratch_folder("numbered_recordings");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  REQUIRE(sample::record(posix_storage(), folder + "/x.mkv", camera, sample::frames(camera, 3, 2)).ok());
  const Error refused =
      sample::error_of(hdrcam_verb("repair " + folder + "/x.mkv -o " + folder + "/take%03d.mkv"));
  CHECK(refused.code == ErrorCode::Invalid);
  CHECK(refused.message.find("has a frame number in its name, and is one file") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder + "/take%03d.mkv"));
  CHECK(hdrcam_verb("repair " + folder + "/x.mkv -o " + folder + "/50%.mkv").ok());
}

TEST_CASE("what is missing is called so, also where the output would go into a folder of its name") {
  const std::string missing = sample::scratch_folder("missing_input") + "/missing";
  const std::string into = " " + missing + " -o " + missing;
  for (const std::string& line : {"import" + into + "/x.mkv", "repair" + into + "/x.mkv", "export" + into}) {
    INFO(line);
    const Error refused = sample::error_of(hdrcam_verb(line));
    CHECK(refused.code == ErrorCode::NotFound);
    CHECK(refused.message == fmt::format("'{}' does not exist", missing));
    CHECK_FALSE(std::filesystem::exists(missing));
  }
}

TEST_CASE("a clip or a picture in place of a recording leads to import, and two clips to one at a time") {
  const std::string folder = sample::scratch_folder("no_recording");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  write_clip(folder + "/a", camera, 3);
  write_clip(folder + "/b", camera, 3);
  for (const char* place : {"/a", "/a/ldr/0001.png"}) {
    const Error refused = sample::error_of(hdrcam_verb("info " + folder + place));
    CHECK(refused.code == ErrorCode::NotRecording);
    CHECK(refused.message.find("'hdrcam import' makes a recording of") != std::string::npos);
  }
  const Error both =
      sample::error_of(hdrcam_verb("import " + folder + "/a " + folder + "/b -o " + folder + "/x.mkv"));
  CHECK(both.code == ErrorCode::Invalid);
  CHECK(both.message.find("/a' is a folder among other footage") != std::string::npos);
  const Error both_clips = sample::error_of(
      hdrcam_verb("import " + folder + "/a/clip.json " + folder + "/b/clip.json -o " + folder + "/x.mkv"));
  CHECK(both_clips.code == ErrorCode::Invalid);
  CHECK(both_clips.message.find("/a/clip.json' is a clip.json among other footage") != std::string::npos);
}

TEST_CASE("export names pictures itself, and asks for their folder where it gets a pattern") {
  const std::string folder = sample::scratch_folder("export_pattern");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  REQUIRE(sample::record(posix_storage(), folder + "/x.mkv", camera, sample::frames(camera, 3, 2)).ok());
  const Error refused =
      sample::error_of(hdrcam_verb("export " + folder + "/x.mkv -o " + folder + "/y/%06d.png"));
  CHECK(refused.code == ErrorCode::Invalid);
  CHECK(refused.message.find("/y/%06d.png' numbers pictures") != std::string::npos);
  CHECK(refused.message.find("--output names their folder") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder + "/y"));
  for (const char* file : {"/y.mkv", "/y/%d.png"}) {
    const Error of_a_file = sample::error_of(hdrcam_verb("export " + folder + "/x.mkv -o " + folder + file));
    CHECK(of_a_file.code == ErrorCode::Invalid);
    CHECK(of_a_file.message.find("is the name of a picture or a video; --output names the folder") !=
          std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder + file));
  }
  CHECK(hdrcam_verb("export " + folder + "/x.mkv -o " + folder + "/y.mkv/").ok());  // surely a folder
}
