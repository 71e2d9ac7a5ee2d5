#include "firmware_host/sinks/output_guard.h"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/hal/recording/sample_recordings.h"

#include "tests/contracts/expect.h"
#include "tests/support/as_nobody.h"

namespace hdrcam {
namespace {

namespace fs = std::filesystem;

// A folder with a recording, and what a run would do in it.
struct Desk {
  explicit Desk(const char* name) : folder(sample::scratch_folder(name)) { put("walk.mkv"); }

  void put(const std::string& file) const {
    fs::create_directories(fs::path(folder + "/" + file).parent_path());
    std::ofstream(folder + "/" + file) << file;
  }
  Result<void> check(std::vector<NamedOutput> outputs, Overwrite overwrite = Overwrite::Refuse) const {
    for (NamedOutput& output : outputs)
      if (!output.path.empty() && !output.path.starts_with('/')) output.path = folder + "/" + output.path;
    const std::vector<NamedInput> inputs{{"the recording that is read", folder + "/walk.mkv"}};
    return check_outputs(posix_storage(), inputs, outputs, overwrite);
  }

  std::string folder;
};

TEST_CASE("no output may be the recording that is read, under any name, even with --force") {
  const Desk desk("guard_input");
  fs::create_symlink("walk.mkv", desk.folder + "/soft.html");
  fs::create_hard_link(desk.folder + "/walk.mkv", desk.folder + "/hard.json");
  fs::create_directory(desk.folder + "/sub");
  for (const char* path : {"walk.mkv", "sub/../walk.mkv", "soft.html", "hard.json"})
    for (const OutputKind kind : {OutputKind::Page, OutputKind::Recording})
      for (const Overwrite overwrite : {Overwrite::Refuse, Overwrite::Force}) {
        INFO(path);
        const Result<void> checked = desk.check({{"--report", path, kind}}, overwrite);
        require_error(checked, ErrorCode::Invalid);
        CHECK(checked.error().message.find("--report") != std::string::npos);
        CHECK(checked.error().message.find("the recording that is read") != std::string::npos);
      }
}

TEST_CASE(
    "what an output finds once its folder is made counts as there, by the way through that folder too") {
  const Desk desk("guard_new_folder");
  for (const char* earlier : {"take.mkv", "000001.exr"}) desk.put(earlier);
  for (const Overwrite overwrite : {Overwrite::Refuse, Overwrite::Force}) {
    require_error(desk.check({{"--report", "new/../walk.mkv"}}, overwrite), ErrorCode::Invalid);
    require_error(desk.check({{"--report", "new/../take.mkv"}}, overwrite), ErrorCode::Invalid);
  }
  require_error(desk.check({{"--record", "new/../take.mkv", OutputKind::Recording}}), ErrorCode::Exists);
  require_done(desk.check({{"--record", "new/../take.mkv", OutputKind::Recording}}, Overwrite::Force));
  require_error(desk.check({{"--output", "new/../%06d.exr", OutputKind::Frames}}), ErrorCode::Exists);
  require_error(desk.check({{"--output", "new/../%06d.exr", OutputKind::Frames}, {"--report", "000002.exr"}},
                           Overwrite::Force),
                ErrorCode::Invalid);
  require_done(desk.check({{"--output", "new/%06d.exr", OutputKind::Frames}}));
  fs::create_directory_symlink(".", desk.folder + "/link");
  require_error(
      desk.check({{"--output", "new/../link/%06d.exr", OutputKind::Frames}, {"--report", "000002.exr"}},
                 Overwrite::Force),
      ErrorCode::Invalid);
}

TEST_CASE("the folder of every output is made, and one that takes no file is found before any work") {
  const Desk desk("guard_room");
  const auto room = [&](std::vector<NamedOutput> outputs) {
    for (NamedOutput& output : outputs)
      if (!output.path.starts_with('/')) output.path = desk.folder + "/" + output.path;
    return make_room_for(posix_storage(), outputs);
  };
  require_done(room({{"--output", "a/%06d.exr", OutputKind::Frames},
                     {"--record", "b/c/take.mkv", OutputKind::Recording},
                     {"--report", "d/report.html"},
                     {"--stats", "/dev/null"}}));
  for (const char* folder : {"/a", "/b/c", "/d"}) {
    CHECK(fs::is_directory(desk.folder + folder));
    CHECK(fs::is_empty(desk.folder + folder));  // what tried them is gone
  }
  const Result<void> no_file = room({{"--report", "/proc/self/report.html"}});
  REQUIRE_FALSE(no_file.ok());
  CHECK(no_file.error().message ==
        "--report '/proc/self/report.html' cannot be written: its folder takes no new files; name another "
        "place");
  CHECK_FALSE(room({{"--report", "walk.mkv/report.html"}}).ok());  // below a file
  CHECK_FALSE(room({{"--report", "a"}}).ok());                     // a folder
}

TEST_CASE("two outputs may not be one file, also before it exists") {
  const Desk desk("guard_outputs");
  require_error(desk.check({{"--stats", "out.json"}, {"--report", "./out.json"}}), ErrorCode::Invalid);
  require_error(desk.check({{"--output", "out/%06d.exr", OutputKind::Frames}, {"--stats", "out/000001.exr"}}),
                ErrorCode::Invalid);
  require_error(desk.check({{"--output", "out/%06d.png", OutputKind::Frames},
                            {"--preview", "out/%04d.png", OutputKind::Frames}}),
                ErrorCode::Invalid);
  require_done(desk.check({{"--output", "out/%06d.exr", OutputKind::Frames},
                           {"--preview", "out/%06d.png", OutputKind::Frames},
                           {"--stats", "out/stats.json"},
                           {"--report", "out/report.html"},
                           {"--sheet", ""}}));
}

TEST_CASE("an output is no file where another one needs a folder, also before that is made") {
  const Desk desk("guard_folder_of_another");
  const NamedOutput frames{"--output", "out/a/%06d.exr", OutputKind::Frames}, stats{"--stats", "out"};
  for (const std::vector<NamedOutput>& outputs : {std::vector{frames, stats}, std::vector{stats, frames}}) {
    const Result<void> checked = desk.check(outputs);
    require_error(checked, ErrorCode::Invalid);
    CHECK_THAT(checked.error().message,
               Catch::StartsWith("--stats '" + desk.folder + "/out' is a file, and --output '"));
  }
  require_error(desk.check({{"--stats", "a/s.json"}, {"--report", "a"}}), ErrorCode::Invalid);
  require_done(desk.check({frames, {"--stats", "out.json"}, {"--report", "out/a.html"}}));
}

// Runs in a folder, as a user does who names files without one.
struct CurrentFolder {
  explicit CurrentFolder(const std::string& folder) { fs::current_path(folder); }
  ~CurrentFolder() { fs::current_path(before); }
  const fs::path before = fs::current_path();
};

TEST_CASE("a missing file of the current folder is one file, under whatever name it is given") {
  const Desk desk("guard_current_folder");
  const CurrentFolder current(desk.folder);
  const std::string up = "../" + fs::path(desk.folder).filename().string() + "/y.mkv";
  for (const std::string& name : {std::string("./y.mkv"), up, desk.folder + "/y.mkv"}) {
    INFO(name);
    const NamedOutput outputs[] = {{"--output", "y.mkv", OutputKind::Recording},
                                   {"--record", name, OutputKind::Recording}};
    for (const Overwrite overwrite : {Overwrite::Refuse, Overwrite::Force})
      require_error(check_outputs(posix_storage(), {}, outputs, overwrite), ErrorCode::Invalid);
  }
  const NamedOutput frame[] = {{"--output", "%06d.exr", OutputKind::Frames}, {"--stats", "000001.exr"}};
  require_error(check_outputs(posix_storage(), {}, frame, Overwrite::Refuse), ErrorCode::Invalid);
}

TEST_CASE("no output goes into a folder that is read, whether its file exists or not, even with --force") {
  const Desk desk("guard_folder");
  desk.put("clip/gt/hdr/0000.exr");
  const std::vector<NamedInput> inputs{{"the ground truth", desk.folder + "/clip/gt", InputKind::Folder}};
  const auto check = [&](const std::string& path, OutputKind kind) {
    const NamedOutput outputs[] = {{"--output", desk.folder + "/" + path, kind}};
    return check_outputs(posix_storage(), inputs, outputs, Overwrite::Force);
  };
  require_error(check("clip/gt/hdr/%04d.exr", OutputKind::Frames), ErrorCode::Invalid);
  require_error(check("clip/gt/%06d.exr", OutputKind::Frames), ErrorCode::Invalid);
  require_error(check("clip/gt/new/stats.json", OutputKind::Page), ErrorCode::Invalid);
  require_done(check("clip/out/%06d.exr", OutputKind::Frames));
  require_done(check("clip/gt.json", OutputKind::Page));
}

TEST_CASE("a document is replaced with --force only, and never stands in for a recording") {
  const Desk desk("guard_document");
  desk.put("camera.toml"), desk.put("take1.mkv");
  const std::vector<NamedOutput> again{{"--output", "camera.toml", OutputKind::Document}};
  require_error(desk.check(again), ErrorCode::Exists);
  require_done(desk.check(again, Overwrite::Force));
  require_error(desk.check({{"--output", "take1.mkv", OutputKind::Document}}, Overwrite::Force),
                ErrorCode::Invalid);
}

TEST_CASE("settings take the place of settings with --force only, and of no clip, poses or recording") {
  const Desk desk("guard_settings");
  for (const char* file : {"camera.toml", "camera.conf"}) {
    desk.put(file);
    const std::vector<NamedOutput> again{{"--output", file, OutputKind::Settings}};
    require_error(desk.check(again), ErrorCode::Exists);
    require_done(desk.check(again, Overwrite::Force));
  }
  for (const char* work :
       {"clip/clip.json", "clip/gt/gt.json", "transforms.json", "take1.mkv", "s.hdrscene"}) {
    desk.put(work);
    require_error(desk.check({{"--output", work, OutputKind::Settings}}, Overwrite::Force),
                  ErrorCode::Invalid);
  }
}

TEST_CASE("poses take the place of poses with --force only, and of no file of another kind") {
  const Desk desk("guard_poses");
  desk.put("transforms.json"), desk.put("sparse/points3D.txt"), desk.put("clip.json"), desk.put("take.mkv");
  for (const char* poses : {"transforms.json", "sparse/points3D.txt"}) {
    INFO(poses);
    const std::vector<NamedOutput> outputs{{"--transforms", poses, OutputKind::Poses}};
    require_error(desk.check(outputs), ErrorCode::Exists);
    require_done(desk.check(outputs, Overwrite::Force));
  }
  for (const char* other : {"clip.json", "take.mkv"})
    require_error(desk.check({{"--transforms", other, OutputKind::Poses}}, Overwrite::Force),
                  ErrorCode::Invalid);
}

TEST_CASE("a list of frames takes the place of a list with --force only, and no page does") {
  const Desk desk("guard_list");
  for (const char* list : {"out/frames.csv", "out/a_frames.csv"}) {
    INFO(list);
    const std::vector<NamedOutput> outputs{{"the list beside --output", list, OutputKind::List}};
    require_done(desk.check(outputs));
    desk.put(list);
    require_error(desk.check(outputs), ErrorCode::Exists);
    require_done(desk.check(outputs, Overwrite::Force));
    const Result<void> page = desk.check({{"--stats", list}}, Overwrite::Force);
    require_error(page, ErrorCode::Invalid);
    CHECK_THAT(page.error().message, Catch::Contains("would replace the list of an earlier run's frames"));
  }
  fs::create_symlink("../walk.mkv", desk.folder + "/out/linked_frames.csv");
  require_error(
      desk.check({{"the list beside --output", "out/linked_frames.csv", OutputKind::List}}, Overwrite::Force),
      ErrorCode::Invalid);
}

TEST_CASE("a contact sheet takes the place of a numbered picture with --force only") {
  const Desk desk("guard_numbered");
  for (const char* picture : {"out/000001.png", "frame_0041.png", "IMG_1234.PNG"}) {
    INFO(picture);
    desk.put(picture);
    const std::vector<NamedOutput> outputs{{"--sheet", picture, OutputKind::Picture}};
    const Result<void> checked = desk.check(outputs);
    require_error(checked, ErrorCode::Exists);
    CHECK(checked.error().message.find("is numbered as a frame is") != std::string::npos);
    require_done(desk.check(outputs, Overwrite::Force));
  }
  desk.put("sheet2.png");
  require_done(desk.check({{"--sheet", "sheet2.png", OutputKind::Picture}}));
  require_done(desk.check({{"--sheet", "out/000002.png", OutputKind::Picture}}));  // nothing is there
}

TEST_CASE("a name that no frame or file can have is refused before its folder is made") {
  const Desk desk("guard_names");
  const auto refused = [&](const NamedOutput& output, const char* reason) {
    const Result<void> checked = desk.check({output});
    require_error(checked, ErrorCode::Invalid);
    CHECK(checked.error().message.find(reason) != std::string::npos);
  };
  refused({"--output", "o/100%%06d.exr", OutputKind::Frames, ".exr"}, "more than one '%'");
  refused({"--preview", "o/%06d.exr", OutputKind::Frames, ".png"}, "does not end in '.png'");
  refused({"--depth", "o/depth.png", OutputKind::Frames, ".png"}, "would put every frame into one file");
  refused({"--stats", "o/", OutputKind::Page}, "names a folder");
  CHECK_FALSE(fs::exists(desk.folder + "/o"));
}

TEST_CASE("a misspelt {start} is refused, and braces in the name of what is there already are not") {
  const Desk desk("guard_words");
  const auto refused = [&](const NamedOutput& output, const std::string& word) {
    INFO(output.path);
    const Result<void> checked = desk.check({output}, Overwrite::Force);
    require_error(checked, ErrorCode::Invalid);
    CHECK(checked.error().message == output.flag + " '" + desk.folder + "/" + output.path + "' has " + word +
                                         " in its name, which stands for nothing; write {start} for the time "
                                         "at which the run starts");
  };
  refused({"--output", "o-{strat}/%06d.exr", OutputKind::Frames, ".exr"}, "{strat}");
  refused({"--record", "take-{Start}.mkv", OutputKind::Recording}, "{Start}");
  refused({"--stats", "o{/{start_time}.json"}, "{start_time}");
  CHECK_FALSE(fs::exists(desk.folder + "/o-{strat}"));
  desk.put("{walk}/notes.txt");
  require_done(desk.check({{"--output", "{walk}/%06d.exr", OutputKind::Frames, ".exr"},
                           {"--stats", "{walk}/new/stats.json"},
                           {"--report", "{}/{1}/a{b,c}.html"}}));
  refused({"--stats", "{walk}/{strat}.json"}, "{strat}");
}

TEST_CASE("an output of one file has no frame number in its name, nor in that of its folder") {
  const Desk desk("guard_number");
  for (const NamedOutput& output :
       {NamedOutput{"--stats", "o/%06d.json"}, NamedOutput{"--report", "o/%06d/report.html"},
        NamedOutput{"--stats", "o/%6d_%03d.json"}, NamedOutput{"--sheet", "o/%06d.png", OutputKind::Picture},
        NamedOutput{"--snapshot", "o/%06d.hdrscene", OutputKind::Scene},
        NamedOutput{"--output", "o/%06d.mp4", OutputKind::Recording},
        NamedOutput{"--transforms", "o/%06d.json", OutputKind::Poses}}) {
    INFO(output.path);
    const Result<void> checked = desk.check({output}, Overwrite::Force);
    require_error(checked, ErrorCode::Invalid);
    CHECK(checked.error().message ==
          output.flag + " '" + desk.folder + "/" + output.path +
              "' has a frame number in its name, and is one file; name it without the number");
  }
  CHECK_FALSE(fs::exists(desk.folder + "/o"));
  require_done(desk.check({{"--stats", "50%/100%.json"}, {"--report", "50%done.html"}}));
  REQUIRE(mkfifo((desk.folder + "/%06d").c_str(), 0600) == 0);
  require_done(desk.check({{"--stats", "%06d"}}));
}

TEST_CASE("who names a device for frames, to time a run without them, learns how that is done") {
  const Desk desk("guard_device");
  const Result<void> frames = desk.check({{"--output", "/dev/null", OutputKind::Frames, ".exr"}});
  require_error(frames, ErrorCode::Invalid);
  CHECK(frames.error().message ==
        "--output '/dev/null' is a device or a FIFO, which takes no numbered files; leave it out and give "
        "--stats stats.json to time a run without them, or give --output - to pipe the frames");
  const Result<void> previews = desk.check({{"--preview", "/dev/null", OutputKind::Frames, ".png"}});
  require_error(previews, ErrorCode::Invalid);
  CHECK(previews.error().message.ends_with("to time a run without them"));
  require_error(desk.check({{"--output", "out", OutputKind::Frames, ".exr"}}), ErrorCode::Invalid);
}

TEST_CASE("a scene takes the place of a scene with --force only, and of no file of another kind") {
  const Desk desk("guard_scene");
  for (const char* file : {"s.hdrscene", "S.HDRSCENE", "take.mkv", "film.mp4", "000001.exr", "clip.json"})
    desk.put(file);
  for (const char* scene : {"s.hdrscene", "S.HDRSCENE"}) {
    const std::vector<NamedOutput> outputs{{"--snapshot", scene, OutputKind::Scene}};
    require_error(desk.check(outputs), ErrorCode::Exists);
    require_done(desk.check(outputs, Overwrite::Force));
  }
  for (const char* other : {"take.mkv", "film.mp4", "000001.exr", "clip.json"}) {
    INFO(other);
    const Result<void> checked = desk.check({{"--snapshot", other, OutputKind::Scene}}, Overwrite::Force);
    require_error(checked, ErrorCode::Invalid);
    CHECK(checked.error().message.find("would replace a") != std::string::npos);
  }
  require_done(desk.check({{"--snapshot", "new.hdrscene", OutputKind::Scene}}));
}

TEST_CASE("a scene is saved under a name that no later page takes for one of its own") {
  const Desk desk("guard_scene_name");
  desk.put("noname");
  for (const char* name : {"new.mkv", "new.dat", "new", "noname"}) {
    INFO(name);
    const Result<void> checked = desk.check({{"--snapshot", name, OutputKind::Scene}}, Overwrite::Force);
    require_error(checked, ErrorCode::Invalid);
    CHECK(checked.error().message.find("is not the name of a saved scene; name it scene.hdrscene") !=
          std::string::npos);
  }
  require_done(desk.check({{"--snapshot", "/dev/null", OutputKind::Scene}}));
}

TEST_CASE("an earlier recording is replaced with --force only") {
  const Desk desk("guard_take");
  desk.put("take1.mkv");
  const std::vector<NamedOutput> outputs{{"--output", "take1.mkv", OutputKind::Recording}};
  const Result<void> checked = desk.check(outputs);
  require_error(checked, ErrorCode::Exists);
  CHECK(checked.error().message.find("--force") != std::string::npos);
  require_done(desk.check(outputs, Overwrite::Force));
  require_done(desk.check({{"--output", "take2.mkv", OutputKind::Recording}}));
}

TEST_CASE("frames go into a folder that cannot be listed with --force only") {
  const Desk desk("guard_closed");
  desk.put("kept/000001.exr");
  fs::permissions(desk.folder + "/kept", fs::perms(0333));
  {
    const test::AsNobody nobody;
    const std::vector<NamedOutput> outputs{{"--output", "kept/%06d.exr", OutputKind::Frames, ".exr"}};
    const Result<void> checked = desk.check(outputs);
    require_error(checked, ErrorCode::Permission);
    CHECK(checked.error().message.find("may replace earlier files") != std::string::npos);
    require_done(desk.check(outputs, Overwrite::Force));
  }
  fs::permissions(desk.folder + "/kept", fs::perms::owner_all);
}

TEST_CASE("frames do not mix with those of an earlier run unless --force says so") {
  const Desk desk("guard_frames");
  const std::vector<NamedOutput> outputs{{"--output", "out/%06d.exr", OutputKind::Frames}};
  require_done(desk.check(outputs));
  desk.put("out/notes.txt"), desk.put("out/poster.exr");
  require_done(desk.check(outputs));
  desk.put("out/000041.exr");
  const Result<void> checked = desk.check(outputs);
  require_error(checked, ErrorCode::Exists);
  CHECK(checked.error().message.find("1 earlier file, '" + desk.folder + "/out/000041.exr' among them") !=
        std::string::npos);
  require_done(desk.check(outputs, Overwrite::Force));
}

TEST_CASE("frames do not mix with those of an earlier run that had another number of digits") {
  const Desk desk("guard_digits");
  desk.put("out/0041.exr");
  const Result<void> checked = desk.check({{"--output", "out/%06d.exr", OutputKind::Frames}});
  require_error(checked, ErrorCode::Exists);
  CHECK(checked.error().message.find("0041.exr") != std::string::npos);
}

TEST_CASE("a page is made anew, but never over a picture or a recording") {
  const Desk desk("guard_page");
  desk.put("report.html"), desk.put("out/000001.exr"), desk.put("other.mkv");
  require_done(desk.check({{"--report", "report.html"}}));
  require_error(desk.check({{"--stats", "out/000001.exr"}}), ErrorCode::Invalid);
  require_error(desk.check({{"--stats", "other.mkv"}}, Overwrite::Force), ErrorCode::Invalid);
  require_done(desk.check({{"--stats", "/dev/null"}, {"--report", "/dev/null"}}));
  for (const char* work : {"a.jpg", "B.JPG", "c.tiff", "d.png", "e.ARW", "f.DNG", "g.MP4", "h.webm", "i.y4m",
                           "j.flo", "k.EXR", "l.MKV"}) {
    INFO(work);
    desk.put(work);
    require_error(desk.check({{"--stats", work}}, Overwrite::Force), ErrorCode::Invalid);
    require_error(desk.check({{"--output", work, OutputKind::Document}}, Overwrite::Force),
                  ErrorCode::Invalid);
  }
  for (const char* work : {"camera.toml", "clip.json", "gt.json", "transforms.json", "colmap/cameras.txt",
                           "colmap/images.txt"}) {
    INFO(work);
    desk.put(work);
    require_error(desk.check({{"--stats", work}}, Overwrite::Force), ErrorCode::Invalid);
  }
  CHECK_THAT(desk.check({{"--stats", "transforms.json"}}).error().message,
             Catch::Contains("would replace the poses of pictures; name another file"));
  require_done(desk.check({{"--stats", "colmap/notes.txt"}}));
  desk.put("sheet.png");
  require_done(desk.check({{"--sheet", "sheet.png", OutputKind::Picture}}));
  require_error(desk.check({{"--sheet", "B.JPG", OutputKind::Picture}}), ErrorCode::Invalid);
}

}  // namespace
}  // namespace hdrcam
