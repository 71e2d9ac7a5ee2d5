// Files for other tools that cannot be: refused by every verb before it writes anything.
#include <filesystem>
#include <string>
#include <vector>

#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/moving_scene.h"

#include "tests/firmware_host/commands/verb_runs.h"

using namespace hdrcam;
using test::ran_here;
using test::RanHere;
namespace fs = std::filesystem;

namespace {

// Recordings of seven frames that state poses, a lens, or both.
struct StatedGeometry {
  explicit StatedGeometry(const char* name)
      : folder(sample::scratch_folder(name)),
        out(folder + "/out"),
        no_poses(recorded("/no_poses.mkv", false, true)),
        no_lens(recorded("/no_lens.mkv", true, false)),
        whole(recorded("/whole.mkv", true, true)) {}

  std::string recorded(const char* name, bool poses, bool lens) const {
    const test::MovingScene scene;
    CameraFacts camera = scene.camera();
    if (!lens) camera.intrinsics.reset();
    auto writer = create_recording(posix_storage(), folder + name, camera).value();
    for (int i = 0; i < 7; ++i) {
      RawFrame frame = scene.frame(i);
      if (poses) frame.facts.T_world_camera = PoseMatrix{1, 0, 0, 0.01 * i, 0, 1, 0, 0, 0, 0, 1, 0};
      REQUIRE(writer->append(frame).ok());
    }
    REQUIRE(writer->finish().ok());
    return folder + name;
  }

  const std::string folder, out, no_poses, no_lens, whole;
};

void check_refused_with(const std::vector<std::string>& words, const std::string& reason) {
  const RanHere run = ran_here(words);
  INFO(run.err);
  CHECK(run.exit_code == exit_code_of(ErrorCode::Invalid));
  CHECK(run.err.find(reason) != std::string::npos);
  CHECK(run.err.find('\n') == run.err.size() - 1);
}

// Files of poses and a model, each with each of the verbs. None of them writes anything: the first frames of
// a fit would be there.
void check_geometry_refused(const std::vector<std::vector<std::string>>& verbs,
                            const std::vector<std::string>& flags, const std::string& folder,
                            const std::string& reason) {
  for (const std::vector<std::string>& verb : verbs)
    for (const std::vector<std::string>& file :
         {std::vector<std::string>{"--transforms", folder + "/t.json"}, {"--colmap", folder + "/colmap"}}) {
      std::vector<std::string> words = verb;
      words.insert(words.end(), flags.begin(), flags.end());
      words.insert(words.end(), {"-o", folder + "/%06d.exr"});
      words.insert(words.end(), file.begin(), file.end());
      INFO(verb.front() << " " << file.front());
      check_refused_with(words, reason);
      CHECK_FALSE(fs::exists(folder));
    }
}

}  // namespace

TEST_CASE("what a recording does not state is not exported, and the error says what to do") {
  const StatedGeometry clips("scene_files_export_refused");
  check_refused_with({"export", clips.no_poses, "-o", clips.out, "--transforms"},
                     "states no poses; 'hdrcam replay");
  check_refused_with({"export", clips.no_lens, "-o", clips.out, "--colmap"}, "states no lens");
  CHECK_FALSE(fs::exists(clips.out));  // before anything is written
}

TEST_CASE("a scene file that cannot be is refused in a sentence that says what to do") {
  const StatedGeometry clips("scene_files_refused");
  const std::string &out = clips.out, &whole = clips.whole;
  const auto refused = [&](std::vector<std::string> flags, const char* reason) {
    flags.insert(flags.begin(), {"replay", whole, "--preset", "fast"});
    check_refused_with(flags, reason);
  };
  const std::string frames = out + "/%06d.exr", transforms = out + "/transforms.json";
  refused({"--transforms", transforms}, "give --output out/%06d.exr or --preview");
  refused({"--flow-forward", out + "/a.flo"}, "would put every frame into one file");
  refused({"--flow-forward", out + "/%06d.exr"}, "does not end in '.flo'");
  refused({"--depth", out + "/%06d.exr"}, "does not end in '.png'");
  refused({"--flow-forward", out + "/%06d.flo", "--lookahead", "0"}, "--lookahead 1");
  refused({"-o", frames, "--layers", "flow_forward", "--lookahead", "0"}, "--lookahead 1");
  refused({"--flow-forward", out + "/%06d.flo", "--set", "look_ahead=0"}, "--set look_ahead=1");
  refused({"--depth", out + "/%06d.png", "--emit", "state"}, "--emit state");
  refused({"-o", frames, "--layers", "depth", "--emit", "state"}, "--layers depth comes from the field");
  refused({"--transforms", whole, "-o", frames}, "would overwrite the file that is read");
  refused({"--transforms", out + "/same.json", "-o", frames, "--stats", out + "/same.json"},
          "would overwrite --stats");
  refused({"--colmap", out, "-o", frames, "--stats", out + "/images.txt"}, "would overwrite");
  check_refused_with(
      {"render", whole, "--stereo", "0.02", "--force", "-o", frames, "--colmap", out + "/colmap"},
      "--stereo");
  check_refused_with(
      {"render", whole, "-o", clips.folder + "/film/%06d.exr", "--flow-backward", out + "/%06d.flo"},
      "--flow-backward' (a flag of replay, live)");
}

TEST_CASE("poses without a lens, or of nobody, are refused by every verb before its fit begins") {
  const StatedGeometry clips("scene_files_refused_early");
  check_refused_with({"replay", clips.no_lens, "--preset", "fast", "--force", "-o", clips.out + "/%06d.exr",
                      "--transforms", clips.out + "/transforms.json"},
                     "states no lens");
  const std::string early = clips.folder + "/early", lens = "replay:" + clips.no_lens,
                    poses = "replay:" + clips.no_poses;
  check_geometry_refused({{"replay", clips.no_lens},
                          {"render", clips.no_lens},
                          {"live", "--camera", lens},
                          {"live", "--camera", lens, "--pace", "realtime"}},
                         {"--preset", "fast"}, early, "'" + clips.no_lens + "' has poses but states no lens");
  check_geometry_refused({{"replay", clips.no_poses},
                          {"replay", clips.whole, "--set", "pose=tracked"},
                          {"live", "--camera", poses},
                          {"live", "--camera", poses, "--pace", "realtime"},
                          {"live", "--camera", "sim:still?size=32x32", "--frames", "2"}},
                         {"--emit", "state"}, early,
                         "none is tracked without the field, which --emit state leaves out");
  const std::vector<std::string> stopped{"replay", clips.no_poses,      "--emit",       "state",
                                         "-o",     early + "/%06d.exr", "--transforms", early + "/t.json"};
  CHECK(ran_here(stopped, posix_storage(), true).exit_code == kExitInterrupted);  // not read to its end
}
