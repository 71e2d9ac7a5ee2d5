// The verb from outside: a small recording, and what the film shows of it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "firmware_host/exit_code.h"
#include "hal/recording/png_image.h"
#include "hal/recording/recording.h"
#include "render/exr.h"
#include "render/hdr_frame.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/moving_scene.h"
#include "tests/support/ran_here.h"
#include "tests/support/stopping_storage.h"

#include "tests/support/ran.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::ran_here;
using test::RanHere;
namespace fs = std::filesystem;

namespace {

constexpr int kFrames = 9;

// The recording that all cases film, made once.
const std::string& clip() {
  static const std::string path = [] {
    const std::string file = sample::scratch_folder("render_clip") + "/clip.mkv";
    const test::MovingScene scene;
    auto writer = create_recording(posix_storage(), file, scene.camera()).value();
    for (int i = 0; i < kFrames; ++i) REQUIRE(writer->append(scene.frame(i)).ok());
    REQUIRE(writer->finish().ok());
    return file;
  }();
  return path;
}

// The files that `hdrcam render CLIP flags..` leaves.
std::vector<std::string> files_of(const std::string& name, std::vector<std::string> flags,
                                  const char* extension = ".exr", const char* verb = "render") {
  const std::string folder = sample::scratch_folder("render_" + name);
  std::vector<std::string> words{verb,        clip(), "--preset", "fast",
                                 "--threads", "2",    "-o",       folder + "/%06d" + extension};
  words.insert(words.end(), flags.begin(), flags.end());
  const RanHere outcome = ran_here(words);
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == extension) files.push_back(entry.path().string());
  std::ranges::sort(files);
  return files;
}

std::vector<ExrImage> film(const std::string& name, const std::vector<std::string>& flags,
                           const char* verb = "render") {
  std::vector<ExrImage> frames;
  for (const std::string& file : files_of(name, flags, ".exr", verb))
    frames.push_back(read_exr(posix_storage(), file).value());
  return frames;
}

// With the field's pixels of a film, which are those of the picture.
const std::vector<ExrImage>& replayed() {
  static const std::vector<ExrImage> frames = film("replayed", {"--set", "field_step=1"}, "replay");
  return frames;
}

const float* plane(const ExrImage& image, std::string_view channel) {
  return image.samples.plane(image.find(channel).value());
}

bool same_radiance(const ExrImage& a, const ExrImage& b) {
  return std::ranges::all_of(exr_channel::kRadiance, [&](std::string_view channel) {
    return std::equal(plane(a, channel), plane(a, channel) + a.samples.plane_size(), plane(b, channel));
  });
}

// Mean absolute difference of ln radiance, green, over the middle of the picture; b is read `shift` to the
// right.
double difference(const ExrImage& a, const ExrImage& b, int shift = 0) {
  const int cols = a.samples.cols(), rows = a.samples.rows();
  double sum = 0;
  int count = 0;
  for (int y = rows / 4; y < rows * 3 / 4; ++y)
    for (int x = cols / 4; x < cols * 3 / 4; ++x, ++count)
      sum += std::abs(std::log(1e-3 + static_cast<double>(plane(a, "G")[y * cols + x])) -
                      std::log(1e-3 + static_cast<double>(plane(b, "G")[y * cols + x + shift])));
  return sum / count;
}

std::string refusal(std::vector<std::string> flags) {
  std::vector<std::string> words{"render", clip()};
  words.insert(words.end(), flags.begin(), flags.end());
  const RanHere outcome = ran_here(words);
  CHECK(outcome.exit_code == exit_code_of(ErrorCode::Invalid));
  return outcome.err;
}

}  // namespace

TEST_CASE("a film from the recorded camera at the recorded times is the replay, pixel by pixel", "[film]") {
  const std::vector<ExrImage> frames = film("same", {"--set", "steps=1"});
  REQUIRE(frames.size() == kFrames);
  for (std::size_t i = 0; i < frames.size(); ++i) CHECK(same_radiance(frames[i], replayed()[i]));
}

TEST_CASE("slow motion shows the recorded frames, and between them what is between", "[film]") {
  const std::vector<ExrImage> frames = film("slow", {"--speed", "0.5", "--set", "steps=1"});
  REQUIRE(frames.size() == 2 * kFrames - 1);
  for (std::size_t i = 0; i < replayed().size(); ++i) CHECK(same_radiance(frames[2 * i], replayed()[i]));
  for (std::size_t i = 7; i < frames.size() - 1; i += 2) {
    const double apart = difference(frames[i - 1], frames[i + 1]);
    CHECK(difference(frames[i], frames[i - 1]) < 0.8 * apart);
    CHECK(difference(frames[i], frames[i + 1]) < 0.8 * apart);
    CHECK(difference(frames[i], frames[i - 1]) > 0.1 * apart);
  }
}

TEST_CASE("a film of one moment shows that moment of the recording and no other", "[film]") {
  const std::vector<ExrImage> frames = film("moment", {"--time", "0.2", "--set", "steps=1"});
  REQUIRE(frames.size() == 1);
  CHECK(same_radiance(frames[0], replayed()[6]));
  CHECK_FALSE(same_radiance(frames[0], replayed()[0]));
}

TEST_CASE("a view turned to the right shows the scene further left, and what no frame saw as the field's",
          "[film]") {
  // the lens is as long as the picture is wide, 64 px: 7.125 degrees are 8 px
  const std::vector<ExrImage> frames = film(
      "turned", {"--time", "0.2", "--view", "0,0,0,7.125,0,0", "--layers", "provenance", "--set", "steps=1"});
  REQUIRE(frames.size() == 1);
  CHECK(difference(frames[0], replayed()[6], 8) < 0.1);
  CHECK(difference(frames[0], replayed()[6], 0) > 0.3);
  const float* provenance = plane(frames[0], "provenance");
  CHECK(provenance[24 * 64 + 62] == static_cast<float>(Provenance::Field));
  CHECK(provenance[24 * 64 + 10] != static_cast<float>(Provenance::Field));
}

TEST_CASE("a path moves the view while time stands still", "[film]") {
  const std::string path = sample::scratch_folder("render_turn") + "/turn.csv";
  const std::string text = "time_s,yaw\n0,0\n0.2,7.125\n";
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(text))).ok());
  const std::vector<ExrImage> frames = film("path", {"--time", "0.2", "--path", path, "--set", "steps=1"});
  REQUIRE(frames.size() == 7);
  CHECK(same_radiance(frames[0], replayed()[6]));
  CHECK(difference(frames[6], replayed()[6], 8) < 0.1);
}

TEST_CASE("a shutter angle blurs what moves along its way and leaves the picture's light as it is",
          "[film]") {
  const std::vector<ExrImage> sharp = film("sharp", {"--time", "0.2", "--set", "steps=1"});
  const std::vector<ExrImage> blurred =
      film("blurred", {"--time", "0.2", "--shutter-angle", "360", "--set", "steps=1"});
  const auto slopes = [](const ExrImage& image) {
    double sum = 0;
    for (int y = 12; y < 36; ++y)
      for (int x = 8; x < 56; ++x)
        sum +=
            std::abs(static_cast<double>(plane(image, "G")[y * 64 + x + 1] - plane(image, "G")[y * 64 + x]));
    return sum;
  };
  const auto light = [](const ExrImage& image) {
    double sum = 0;
    for (int i = 8 * 64; i < 40 * 64; ++i) sum += static_cast<double>(plane(image, "G")[i]);
    return sum;
  };
  CHECK(slopes(blurred[0]) < 0.95 * slopes(sharp[0]));
  CHECK(light(blurred[0]) == Approx(light(sharp[0])).epsilon(0.05));
}

TEST_CASE("a film of what no recorded frame shows is told from one of the scene", "[film]") {
  const std::string folder = sample::scratch_folder("render_far");
  const auto told = [&](const std::string& view) {
    const test::Ran run = test::ran({"render", clip(), "--preset", "fast", "--time", "0.2", "--view", view,
                                     "--force", "-o", folder + "/%06d.exr"});
    INFO(run.output);
    CHECK(run.exit_code == 0);
    return run.output.find("warning: no recorded frame shows") != std::string::npos;
  };
  CHECK(told("1000,0,0"));
  CHECK_FALSE(told("0.05,0,0"));
}

TEST_CASE("a film that shows a few recorded pixels is not said to be 100 percent made up", "[film]") {
  const std::string folder = sample::scratch_folder("render_nearly_all"), stats = folder + "/stats.json";
  const test::Ran run =
      test::ran({"render", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", "--preset", "fast", "--time", "0.2",
                 "--view", "1.06,0,0", "--force", "-o", folder + "/%06d.exr", "--stats", stats});
  REQUIRE(run.exit_code == 0);
  const std::string notes = nlohmann::json::parse(read_whole(posix_storage(), stats).value())["notes"].dump();
  CAPTURE(notes);
  REQUIRE_THAT(notes, Contains("film: 1 frame; 99."));  // of its pixels; 99.5 and more would round up
  CHECK_THAT(run.output, Contains("no recorded frame shows 99 % of the film"));
}

TEST_CASE("an exposure of its own shows what the camera recorded at that exposure", "[film]") {
  // frame 7 was exposed for 4 ms
  const auto files =
      files_of("ldr", {"--time", "0.2333333", "--exposure", "4ms", "--set", "steps=1"}, ".png");
  REQUIRE(files.size() == 1);
  const Image<std::uint16_t> picture = read_png(posix_storage(), files[0], 64, 48).value().samples;
  const RawFrame taken = test::MovingScene().frame(7);
  double sum = 0;
  for (std::size_t i = 0; i < taken.codes.size(); ++i)
    sum +=
        std::abs(static_cast<double>(picture.samples()[i]) - static_cast<double>(taken.codes.samples()[i]));
  CHECK(sum / static_cast<double>(taken.codes.size()) < 6);
}

TEST_CASE("the white balance of a film is of its light: twice the gain shows what twice the exposure does",
          "[film]") {
  const auto shown = [](const std::string& name, const std::vector<std::string>& flags) {
    std::vector<std::string> all{"--time", "0.2333333", "--set", "steps=1"};
    all.insert(all.end(), flags.begin(), flags.end());
    return read_png(posix_storage(), files_of(name, all, ".png").at(0), 64, 48).value().samples;
  };
  const auto balanced = shown("balanced", {"--exposure", "2ms", "--white-balance", "2,2,2"});
  const auto longer = shown("longer", {"--exposure", "4ms"});
  const auto plain = shown("plain", {"--exposure", "2ms"});
  double difference = 0, effect = 0;
  for (std::size_t i = 0; i < longer.size(); ++i) {
    const auto code = static_cast<double>(longer.samples()[i]);
    difference += std::abs(static_cast<double>(balanced.samples()[i]) - code);
    effect += std::abs(static_cast<double>(plain.samples()[i]) - code);
  }
  CHECK(difference < 0.02 * effect);
}

TEST_CASE("a stereo film has both eyes side by side, each from its own place", "[film]") {
  const std::vector<ExrImage> frames =
      film("stereo", {"--time", "0.2", "--stereo", "0.2", "--size", "96x48", "--set", "steps=1"});
  REQUIRE(frames.size() == 1);
  CHECK(frames[0].samples.cols() == 192);
  CHECK(frames[0].samples.rows() == 48);
  CHECK_FALSE(frames[0].attributes.T_world_camera);  // of neither eye
  double apart = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 96; ++x)
      apart += std::abs(
          static_cast<double>(plane(frames[0], "G")[y * 192 + x] - plane(frames[0], "G")[y * 192 + 96 + x]));
  CHECK(apart > 1);
}

TEST_CASE("a film ends after the current frame when it is told to stop, however long it was to be",
          "[film]") {
  const std::string folder = sample::scratch_folder("render_stopped"), path = folder + "/long.csv";
  const std::string text = "time_s,yaw\n0,0\n100,7\n";
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(text))).ok());
  test::StoppingStorage storage(".exr", 3);
  const std::vector<std::string> words{"render", clip(), "--preset", "fast", "--set", "steps=1",
                                       "--time", "0.1",  "--path",   path,   "-o",    folder + "/%06d.exr"};
  const RanHere outcome = ran_here(words, storage, storage.stop());
  INFO(outcome.err);
  CHECK(outcome.exit_code == exit_code_of(ErrorCode::Interrupted));
  CHECK_THAT(outcome.err, Contains("of 3001 frames of the film; they are complete"));
  const auto pictures = std::ranges::count_if(
      fs::directory_iterator(folder), [](const auto& entry) { return entry.path().extension() == ".exr"; });
  CHECK(pictures >= 3);
  CHECK(pictures < 100);
}

TEST_CASE("the video of a film of 8-bit pictures is a video, and replaces no picture", "[film]") {
  const std::string folder = sample::scratch_folder("render_ldr_video"), kept = folder + "/000000.png";
  const std::string text = "an earlier picture";
  REQUIRE(write_whole(posix_storage(), kept, std::as_bytes(std::span(text))).ok());
  const auto refused_video = [&](const char* name) {
    return refusal({"--ldr", "--time", "0.2", "--set", "steps=1", "--video", folder + name});
  };
  CHECK_THAT(refused_video("/%06d.png"), Contains("has a frame number in its name, and is one file"));
  CHECK_THAT(refused_video("/film.png"), Contains("is not the name of a video"));
  CHECK(read_whole(posix_storage(), kept).value() == text);
}

TEST_CASE("what the verb cannot do is said before anything is written", "[film]") {
  const std::string folder = sample::scratch_folder("render_refused"), frames = folder + "/x/%06d.exr";
  CHECK_THAT(refusal({}), Contains("nothing to write; give --output"));
  CHECK_THAT(refusal({"-o", frames, "--time", "9.5"}),
             Contains("--time 9.5 is outside the recording, which spans 0 to"));
  CHECK_THAT(refusal({"-o", frames, "--view", "left"}), Contains("--view takes dx,dy,dz"));
  CHECK_THAT(refusal({"-o", frames, "--view", "-1,0"}), Contains("--view takes dx,dy,dz"));
  CHECK_THAT(refusal({"-o", frames, "--shutter-angle", "400"}),
             Contains("--shutter-angle takes a number, 0..360"));
  CHECK_THAT(refusal({"-o", frames, "--speed", "0"}), Contains("--speed takes a number, 0.001..1000"));
  CHECK_THAT(refusal({"-o", frames, "--exposure", "4ms"}), Contains("make 8-bit pictures"));
  CHECK_THAT(refusal({"-o", "-", "--ldr"}), Contains("8-bit pictures, which '-' does not hold"));
  CHECK_THAT(ran_here({"render", "--help"}).out, Contains("the standard output, without --ldr"));
  CHECK_THAT(refusal({"-o", folder + "/x/%06d.png"}), Contains("give --exposure 4ms or --ldr"));
  CHECK_THAT(refusal({"-o", frames, "--stereo", "63mm"}),
             Contains("the poses are tracked and have no metres"));
  for (const char* motion : {"flow", "flow_forward", "field_flow", "field_flow_forward"})
    CHECK_THAT(refusal({"-o", frames, "--layers", motion}),
               Contains(std::string("--layers ") + motion + " writes the motion between recorded frames"));
  CHECK_THAT(refusal({"-o", frames, "--view", "0.1,0,0", "--emit", "state"}),
             Contains("leave out --emit state"));
  for (const auto& [flag, value] : {std::pair("--transforms", "/x/t.json"), {"--colmap", "/x/colmap"}})
    CHECK_THAT(refusal({"-o", frames, "--time", "0.2", "--stereo", "0.02", flag, folder + value}),
               Contains(std::string(flag) + " needs pictures of one lens"));
  CHECK_THAT(refusal({"-o", folder + "/x/a.mp4", "--ldr", "--white", "100"}),
             Contains("pictures for SDR displays; leave out --white"));
  CHECK_THAT(refusal({"-o", folder + "/x/a.mp4", "--ldr", "--transfer", "hlg"}),
             Contains("leave out --transfer"));
  CHECK_FALSE(fs::exists(folder + "/x"));
  CHECK(ran_here({"render", folder + "/none.mkv", "-o", frames}).exit_code ==
        exit_code_of(ErrorCode::NotFound));
}
