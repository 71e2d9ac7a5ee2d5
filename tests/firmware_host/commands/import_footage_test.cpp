// Footage of other cameras becomes a recording, as the user calls it.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "firmware_host/commands/command.h"
#include "firmware_host/footage/described_plan.h"
#include "firmware_host/footage/footage_plan.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/png_image.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/dng_file.h"
#include "tests/support/footage_files.h"
#include "tests/support/moving_scene.h"
#include "tests/support/ran.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

Result<void> import_verb(const std::string& line) {
  CLI::App app;
  Verb verb;
  add_import(app, verb);
  app.parse("import " + line);
  const std::atomic<bool> stop = false;
  Surroundings around{posix_storage(), stop};
  return verb(around);
}

test::MovingScene scene() {
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  return scene;
}

// Which frames of the scene are filmed: `count` from `first`, without those that are lost.
std::vector<int> filmed(int first, int count, const std::vector<int>& lost) {
  std::vector<int> frames;
  for (int i = first; i < first + count; ++i)
    if (std::ranges::find(lost, i) == lost.end()) frames.push_back(i);
  return frames;
}

std::vector<Image<std::uint16_t>> pictures(const std::vector<int>& frames) {
  std::vector<Image<std::uint16_t>> all;
  for (const int i : frames) all.push_back(scene().frame(i).codes);
  return all;
}

// The recording's labels are those of the scene.
void check_labels(const std::string& recording, const std::vector<int>& frames) {
  const auto replayed = sample::replay(posix_storage(), recording);
  REQUIRE_FALSE(replayed.error);
  REQUIRE(replayed.frames.size() == frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameFacts& facts = replayed.frames[i].facts;
    const double truth_s = scene().exposures_s[static_cast<std::size_t>(frames[i]) % 3];
    INFO("frame " << i << " of " << recording);
    CHECK(facts.exposure_s == Approx(truth_s));
    CHECK(facts.slot == frames[i] % 3);
    CHECK(facts.sequence == static_cast<std::uint64_t>(frames[i] - frames[0]));
    CHECK((facts.flags & kFrameExposureUnproved) == 0);
  }
}

std::vector<double> times_in(const std::string& recording) {
  const auto replayed = sample::replay(posix_storage(), recording);
  REQUIRE_FALSE(replayed.error);
  std::vector<double> times_s;
  for (const RawFrame& frame : replayed.frames) times_s.push_back(frame.facts.timestamp.seconds());
  return times_s;
}

}  // namespace

TEST_CASE(
    "videos of alternating exposures get each frame's exposure, whatever the first one is and what is lost") {
  const std::string folder = sample::scratch_folder("import_video");
  const struct {
    const char* name;
    VideoCodec codec;
    int first;
    std::vector<int> lost;
  } videos[] = {{"a.mp4", VideoCodec::H264, 0, {}},
                {"b.mkv", VideoCodec::Hevc, 2, {}},
                {"c.mov", VideoCodec::H264, 1, {9, 20, 21}}};
  for (const auto& video : videos) {
    const std::vector<int> frames = filmed(video.first, 36, video.lost);
    const std::string path = folder + "/" + video.name;
    REQUIRE(
        test::write_video(path, video.codec, pictures(frames)).ok());  // its times do not tell of the losses
    const auto imported = import_verb(path + " -o " + path + ".rec.mkv --shutter 1ms,4ms,16ms");
    INFO((imported.ok() ? "" : imported.error().message));
    REQUIRE(imported.ok());
    check_labels(path + ".rec.mkv", frames);
    const std::vector<double> times_s = times_in(path + ".rec.mkv");  // a lost frame is a longer one
    for (std::size_t i = 0; i < frames.size(); ++i)
      CHECK(std::lround(30 * (times_s[i] - times_s[0])) == frames[i] - frames[0]);
  }
}

TEST_CASE("a folder of brackets with EXIF needs no flag") {
  const std::string folder = sample::scratch_folder("import_exif");
  const std::vector<int> frames = filmed(0, 9, {});
  for (const int i : frames) {
    const test::Exif exif{
        static_cast<std::uint32_t>(std::lround(scene().exposures_s[static_cast<std::size_t>(i) % 3] * 1000)),
        1000, 100, 80};
    test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, 95 + i), scene().frame(i).codes, exif);
  }
  const std::string out = sample::scratch_folder("import_exif_out") + "/x.mkv";
  REQUIRE(import_verb(folder + " -o " + out).ok());
  check_labels(out, frames);
  CHECK(sample::replay(posix_storage(), out).frames[0].facts.exposure_source == ExposureSource::Embedded);
}

namespace {

// A bracket of nine stills, taken at these times.
std::string write_bracket(const std::string& name, const std::vector<std::string>& times,
                          const std::vector<std::string>& sub_seconds) {
  const std::string folder = sample::scratch_folder(name);
  for (int i = 0; i < 9; ++i) {
    const auto place = static_cast<std::size_t>(i);
    test::Exif exif{static_cast<std::uint32_t>(std::lround(scene().exposures_s[place % 3] * 1000)), 1000, 100,
                    80};
    exif.date_time = times[place], exif.sub_second = sub_seconds[place];
    test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), scene().frame(i).codes, exif);
  }
  return folder;
}

}  // namespace

TEST_CASE("stills come at the times that EXIF states, brackets close together and pauses between them") {
  const std::string t = "2026:11:22 17:00:0";
  const std::vector<std::string> seconds{t + "0", t + "0", t + "0", t + "4", t + "4",
                                         t + "4", t + "8", t + "8", t + "8"};
  const std::vector<std::string> parts{"10", "35", "60", "00", "25", "50", "00", "25", "50"};
  const std::string folder = write_bracket("import_times", seconds, parts);
  const std::string out = sample::scratch_folder("import_times_out") + "/x.mkv";
  REQUIRE(import_verb(folder + " -o " + out).ok());
  const std::vector<double> expected{0, .25, .5, 3.9, 4.15, 4.4, 7.9, 8.15, 8.4};
  const std::vector<double> times = times_in(out);
  REQUIRE(times.size() == 9);
  for (std::size_t i = 0; i < 9; ++i) CHECK(times[i] == Approx(expected[i]).margin(1e-9));
  check_labels(out, filmed(0, 9, {}));  // a pause is no loss
  CHECK(open_recording(posix_storage(), out).value()->camera().framerate_hz == Approx(4));

  // A frame rate that the user names comes first.
  REQUIRE(import_verb(folder + " --framerate 10 --force -o " + out).ok());
  const std::vector<double> named = times_in(out);
  for (std::size_t i = 0; i < 9; ++i) CHECK(named[i] == Approx(0.1 * static_cast<double>(i)).margin(1e-9));
}

// What `import --list` says of the footage in a folder.
std::string listed(const std::string& folder) {
  const std::atomic<bool> stop = false;
  FootageRequest request;
  request.files = footage_in(folder).value();
  const auto plan = plan_footage(posix_storage(), request, stop);
  REQUIRE(plan.ok());
  return described(plan.value());
}

TEST_CASE("stills whose EXIF resolves seconds only come at the frame rate, and the list says why") {
  const std::string t = "2026:11:22 17:00:0";
  const std::string folder = write_bracket(
      "import_coarse", {t + "0", t + "0", t + "1", t + "1", t + "2", t + "2", t + "3", t + "3", t + "4"},
      std::vector<std::string>(9));
  const std::string out = sample::scratch_folder("import_coarse_out") + "/x.mkv";
  REQUIRE(import_verb(folder + " -o " + out).ok());
  const std::vector<double> times = times_in(out);
  for (std::size_t i = 0; i < 9; ++i) CHECK(times[i] == Approx(static_cast<double>(i) / 30).margin(1e-8));
  CHECK_THAT(listed(folder), Contains("times: at 30 frames per second, for EXIF has times in steps of 1 s"));
}

TEST_CASE("a raw stream of H.264, which has no times, comes at its frame rate or at the one named") {
  const std::string folder = sample::scratch_folder("import_raw_stream"), out = folder + "/x.mkv";
  const std::vector<int> frames = filmed(0, 24, {});
  REQUIRE(test::write_video(folder + "/x.mp4", VideoCodec::H264, pictures(frames)).ok());
  REQUIRE(test::write_raw_h264(folder + "/x.mp4", folder + "/x.h264").ok());
  REQUIRE(import_verb(folder + "/x.h264 --shutter 1ms,4ms,16ms -o " + out).ok());
  check_labels(out, frames);
  const double rate_hz = open_recording(posix_storage(), out).value()->camera().framerate_hz;
  const std::vector<double> times = times_in(out);
  for (std::size_t i = 0; i < times.size(); ++i)
    CHECK(times[i] == Approx(static_cast<double>(i) / rate_hz).margin(1e-8));
  REQUIRE(import_verb(folder + "/x.h264 --shutter 1ms,4ms,16ms --framerate 50 --force -o " + out).ok());
  CHECK(open_recording(posix_storage(), out).value()->camera().framerate_hz == Approx(50));
  CHECK(times_in(out).back() == Approx(23. / 50).margin(1e-8));
}

namespace {

// The green of pictures as Y4M, which states a rate and no times.
void write_y4m(const std::string& path, const std::vector<Image<std::uint16_t>>& rgb) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format("YUV4MPEG2 W{} H{} F30:1 Ip A1:1 Cmono\n", rgb[0].cols(), rgb[0].rows());
  for (const Image<std::uint16_t>& picture : rgb) {
    file << "FRAME\n";
    for (std::size_t i = 0; i < picture.plane_size(); ++i) file.put(static_cast<char>(picture.plane(1)[i]));
  }
}

}  // namespace

TEST_CASE("--framerate is that of Y4M, which has no times, and refused of a video that has them") {
  const std::string folder = sample::scratch_folder("import_framerate"), out = folder + "/x.mkv";
  const std::vector<int> frames = filmed(0, 24, {});
  write_y4m(folder + "/x.y4m", pictures(frames));
  REQUIRE(import_verb(folder + "/x.y4m --shutter 1ms,4ms,16ms -o " + out).ok());
  CHECK(times_in(out).back() == Approx(23. / 30).margin(1e-8));
  REQUIRE(import_verb(folder + "/x.y4m --shutter 1ms,4ms,16ms --framerate 50 --force -o " + out).ok());
  check_labels(out, frames);
  CHECK(open_recording(posix_storage(), out).value()->camera().framerate_hz == Approx(50));
  CHECK(times_in(out).back() == Approx(23. / 50).margin(1e-8));

  const std::string video = folder + "/x.mp4";
  REQUIRE(test::write_video(video, VideoCodec::H264, pictures(frames)).ok());
  const auto refused = import_verb(video + " --shutter 1ms,4ms,16ms --framerate 50 --list");
  CHECK(sample::error_of(refused).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(refused).message, Contains(video) && Contains("leave out --framerate"));
}

namespace {

// Of a Matroska video of the scene with frames at these times.
FootagePlan plan_of_matroska(const std::string& name, const std::vector<double>& times_s, double rate_hz) {
  const std::string path = sample::scratch_folder(name) + "/x.mkv";
  const std::vector<int> frames = filmed(0, static_cast<int>(times_s.size()), {});
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(frames), times_s, rate_hz).ok());
  const std::atomic<bool> stop = false;
  auto plan = plan_footage(posix_storage(), {.files = {path}, .shutter = "1ms,4ms,16ms", .gain = ""}, stop);
  REQUIRE(plan.ok());
  return std::move(plan).value();
}

}  // namespace

TEST_CASE("times in whole milliseconds give the video's frame rate, and no frame for missing") {
  for (const double rate_hz : {24., 60., 120., 480.}) {
    std::vector<double> times_s;
    for (int i = 0; i < 24; ++i) times_s.push_back(i / rate_hz);
    const FootagePlan plan = plan_of_matroska("import_milliseconds", times_s, rate_hz);
    INFO(rate_hz);
    CHECK(plan.camera.framerate_hz == Approx(rate_hz).epsilon(1e-6));
    for (std::size_t i = 0; i < plan.facts.size(); ++i) CHECK(plan.facts[i].sequence == i);
  }
}

TEST_CASE("videos of different frame rates do not make one clip, and both are named with their rates") {
  const std::string folder = sample::scratch_folder("import_rates");
  const std::string a = folder + "/a.mp4", b = folder + "/b.mp4";
  REQUIRE(test::write_video(a, VideoCodec::H264, pictures(filmed(0, 12, {})), {}, 30).ok());
  REQUIRE(test::write_video(b, VideoCodec::H264, pictures(filmed(12, 12, {})), {}, 15).ok());
  const auto imported = import_verb(a + " " + b + " -o " + folder + "/x.mkv --shutter 1ms,4ms,16ms");
  REQUIRE_FALSE(imported.ok());
  CHECK(imported.error().code == ErrorCode::Invalid);
  CHECK_THAT(imported.error().message, Contains("b.mp4' has 15 frames") && Contains("a.mp4' 30,"));
}

TEST_CASE("a pause of years is a loss of very many frames") {
  std::vector<double> times_s;
  for (int i = 0; i < 12; ++i) times_s.push_back(i / 30. + (i < 6 ? 0 : 143165576));
  const FootagePlan plan = plan_of_matroska("import_years", times_s, 30);
  CHECK(plan.facts.back().sequence > 1'000'000'000);
  CHECK_THAT(describe_missing(plan), Contains("frames are missing, before frame 6"));
}

TEST_CASE("with no exposures at all the ratios are estimated, and the recording says so of every frame") {
  const std::string path = sample::scratch_folder("import_auto") + "/x.mp4";
  const std::vector<int> frames = filmed(1, 36, {});
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(frames)).ok());
  REQUIRE(import_verb(path + " -o " + path + ".mkv --shutter auto").ok());
  const auto replayed = sample::replay(posix_storage(), path + ".mkv");
  REQUIRE(replayed.frames.size() == 36);
  for (std::size_t i = 0; i + 3 < 36; ++i) {
    const FrameFacts &a = replayed.frames[i].facts, &b = replayed.frames[i + 1].facts;
    CHECK(a.exposure_source == ExposureSource::Estimated);
    CHECK(a.verdict == Verdict::Estimated);
    const bool brighter = frames[i + 1] % 3 != 0;
    const double stops = std::log2(b.exposure_s / a.exposure_s);
    CHECK(stops ==
          Approx(brighter ? 2 : -4).margin(brighter ? 1 : 2));  // relative, under a response nobody knows
    CHECK(replayed.frames[i + 3].facts.exposure_s == a.exposure_s);
  }
}

TEST_CASE("the ratios of raw stills are estimated above the black level that they state") {
  const std::string folder = sample::scratch_folder("import_raw_black");
  FootageRequest request{.files = {}, .shutter = kAutoShutter, .gain = ""};
  for (int i = 0; i < 12; ++i) {
    test::DngStill still;
    still.black = 512;  // 32 codes of 255: more than is assumed where none is stated
    still.code_at = [&](int y, int x) {
      const double light = 0.2 + 0.375 * (std::sin(x * 0.21) * std::cos(y * 0.17) + 1);
      return static_cast<std::uint16_t>(still.black + std::lround(800 * light * (1 << i % 3)));
    };
    request.files.push_back(test::write_dng(fmt::format("{}/{:02}.dng", folder, i), still));
  }
  const std::atomic<bool> stop = false;
  const auto plan = plan_footage(posix_storage(), request, stop);
  REQUIRE(plan.ok());
  REQUIRE(plan.value().cycle.size() == 3);
  for (std::size_t slot = 1; slot < 3; ++slot)
    CHECK(plan.value().cycle[slot].product() / plan.value().cycle[slot - 1].product() ==
          Approx(2).epsilon(0.03));
}

TEST_CASE("footage that does not say its exposures is not guessed at") {
  const std::string path = sample::scratch_folder("import_unknown") + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(filmed(0, 12, {}))).ok());
  const auto unknown = import_verb(path + " -o " + path + ".mkv");
  CHECK(sample::error_of(unknown).code == ErrorCode::BadExposure);
  CHECK_THAT(sample::error_of(unknown).message, Contains(path) && Contains("--shutter"));
  const auto wrong = import_verb(path + " -o " + path + ".mkv --shutter 16ms,1ms");
  CHECK(sample::error_of(wrong).code == ErrorCode::BadExposure);
  CHECK_FALSE(std::filesystem::exists(path + ".mkv"));
}

TEST_CASE("where --shutter auto finds no cycle that the pictures keep, it is not proposed again") {
  const std::string folder = sample::scratch_folder("import_unsteady");
  test::MovingScene unsteady = scene();
  unsteady.drift_px = unsteady.disc_px = 0;
  unsteady.exposures_s.assign(13, 0.001);  // most are alike
  for (int i = 0; i < 7; ++i) unsteady.exposures_s.push_back(i % 2 == 0 ? 0.016 : 0.001);
  for (int i = 0; i < 20; ++i)
    test::write_jpeg(fmt::format("{}/{:02}.jpg", folder, i), unsteady.frame(i).codes, std::nullopt);
  const auto refused = import_verb(folder + " -o " + folder + "/x.mkv --shutter auto");
  CHECK(sample::error_of(refused).code == ErrorCode::BadExposure);
  CHECK_THAT(sample::error_of(refused).message, Contains("give it with --shutter") && !Contains("auto"));
}

TEST_CASE("the first file that does not say its exposure is named, not the first of all") {
  const std::string folder = sample::scratch_folder("import_silent");
  for (int i = 0; i < 6; ++i)
    test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), scene().frame(i).codes,
                     i == 4 ? std::nullopt : std::optional(test::Exif{1, 100, 100, 80}));
  const auto refused = import_verb(folder + " -o " + folder + "/x.mkv");
  CHECK(sample::error_of(refused).code == ErrorCode::BadExposure);
  CHECK_THAT(sample::error_of(refused).message,
             Contains("/IMG_4.JPG' does not say") && Contains("EXIF of JPEG and raw stills"));
}

TEST_CASE(
    "a sensitivity or an f-number that some files leave out is not guessed at, one that all leave out is no "
    "matter") {
  const auto imported = [](const char* name, const std::function<void(int, test::Exif&)>& change) {
    const std::string folder = sample::scratch_folder(name);
    for (int i = 0; i < 6; ++i) {
      test::Exif exif{1u << 2 * (i % 3), 1000, 400, 80};
      change(i, exif);
      test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), scene().frame(i).codes, exif);
    }
    return import_verb(folder + " -o " + folder + "/x.mkv");
  };
  const auto no_iso = imported("import_no_iso", [](int i, test::Exif& exif) {
    if (i == 4) exif.iso = 0;
  });
  CHECK(sample::error_of(no_iso).code == ErrorCode::BadExposure);
  CHECK_THAT(sample::error_of(no_iso).message,
             Contains("/IMG_4.JPG' does not state its sensitivity") && Contains("/IMG_0.JPG' does"));
  const auto no_aperture = imported("import_no_aperture", [](int i, test::Exif& exif) {
    if (i == 0) exif.f_number_tenths = 0;
  });
  CHECK(sample::error_of(no_aperture).code == ErrorCode::BadExposure);
  CHECK_THAT(sample::error_of(no_aperture).message,
             Contains("/IMG_0.JPG' does not state its f-number") && Contains("/IMG_1.JPG' does"));
  CHECK(
      imported("import_neither", [](int, test::Exif& exif) { exif.iso = 0, exif.f_number_tenths = 0; }).ok());
}

TEST_CASE("stills without any time come at the frame rate, and the list says so") {
  const std::string folder =
      write_bracket("import_no_times", std::vector<std::string>(9), std::vector<std::string>(9));
  CHECK_THAT(listed(folder),
             Contains("times: at 30 frames per second, for none of them says in EXIF when it was taken"));
}

TEST_CASE("of cut footage what is there is imported, and the end says how much is missing") {
  const std::string path = sample::scratch_folder("import_cut") + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(filmed(0, 30, {}))).ok());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const auto imported = import_verb(path + " -o " + path + ".mkv --shutter 1ms,4ms,16ms");
  CHECK(sample::error_of(imported).code == ErrorCode::Truncated);
  CHECK_THAT(sample::error_of(imported).message, Contains(path) && Contains("of its frames are missing"));
  const auto replayed = sample::replay(posix_storage(), path + ".mkv");
  CHECK_FALSE(replayed.error);
  CHECK(replayed.frames.size() < 30);
  check_labels(path + ".mkv", filmed(0, static_cast<int>(replayed.frames.size()), {}));
}

TEST_CASE("footage that is another one when it is read again gives no frame another's exposure") {
  FootageRequest request;
  request.files = {sample::scratch_folder("import_again") + "/x.mkv"};
  request.shutter = "1ms,4ms,16ms";
  const std::atomic<bool> stop = false;
  REQUIRE(test::write_video(request.files[0], VideoCodec::H264, pictures(filmed(0, 24, {}))).ok());
  const auto plan = plan_footage(posix_storage(), request, stop);
  REQUIRE(plan.ok());
  const std::vector<int> frames = filmed(0, 26, {9, 10});  // as many as before
  std::vector<double> times_s;
  for (const int i : frames) times_s.push_back(i / 30.0);
  REQUIRE(test::write_video(request.files[0], VideoCodec::H264, pictures(frames), times_s).ok());
  auto again = open_planned(posix_storage(), request, plan.value());
  REQUIRE(again.ok());
  for (int i = 0; i < 9; ++i) REQUIRE(again.value()->next({}).ok());
  const auto other = again.value()->next({});
  CHECK(sample::error_of(other).code == ErrorCode::Corrupt);
  CHECK_THAT(sample::error_of(other).message, Contains("frame 9 of 'x' is another one"));
}

TEST_CASE("a damaged still ends the import, and nothing is written") {
  const std::string folder =
      write_bracket("import_damaged", std::vector<std::string>(9), std::vector<std::string>(9));
  const std::string damaged = folder + "/IMG_5.JPG", out = folder + "/x.mkv";
  std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) / 2);
  const auto refused = import_verb(folder + " -o " + out);
  CHECK(sample::error_of(refused).code == ErrorCode::Corrupt);
  CHECK_THAT(sample::error_of(refused).message, Contains(damaged));
  CHECK_FALSE(std::filesystem::exists(out));
}

TEST_CASE("a recording is no footage: in a folder it is left out, by its name it is refused") {
  const std::string folder =
      write_bracket("import_own", std::vector<std::string>(9), std::vector<std::string>(9));
  REQUIRE(import_verb(folder + " -o " + folder + "/new.mkv").ok());
  const std::string out = sample::scratch_folder("import_own_out") + "/x.mkv";
  REQUIRE(import_verb(folder + " -o " + out).ok());
  check_labels(out, filmed(0, 9, {}));
  const auto again = import_verb(folder + "/new.mkv --shutter auto -o " + out + ".mkv");
  CHECK(sample::error_of(again).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(again).message, Contains("new.mkv' is a recording already"));
}

TEST_CASE("a recording that is cut or damaged before its first frame is called so, and is no footage") {
  const std::string folder =
      write_bracket("import_stub", std::vector<std::string>(9), std::vector<std::string>(9));
  const std::string out = sample::scratch_folder("import_stub_out"), whole = out + "/whole.mkv",
                    stub = folder + "/stub.mkv";
  REQUIRE(import_verb(folder + " -o " + whole).ok());
  const std::string bytes = read_whole(posix_storage(), whole).value();
  const std::size_t first_frame = bytes.find("\x1f\x43\xb6\x75"), width = bytes.find("\"width\":");
  REQUIRE(width < first_frame);
  std::string other_width = bytes;
  ++other_width[width + 8];
  const std::pair<std::string, const char*> stubs[] = {
      {bytes.substr(0, 40), "ends before its first frame"},
      {bytes.substr(0, width), "ends before its first frame"},
      {bytes.substr(0, first_frame + 20), "ends before its first frame"},
      {other_width, "is damaged: the checksum of its camera facts does not hold"}};
  for (const auto& [text, why] : stubs) {
    std::ofstream(stub, std::ios::binary) << text;
    const std::string reason = fmt::format("'{}' {}", stub, why);
    INFO(text.size() << " bytes");
    const test::Ran imported = test::ran({"import", folder, "-o", out + "/x.mkv", "--force"});
    CHECK(imported.exit_code == 0);
    CHECK_THAT(imported.output, Contains("warning: " + reason + "; this damaged recording is left out"));
    check_labels(out + "/x.mkv", filmed(0, 9, {}));
    CHECK(sample::error_of(import_verb(stub + " --shutter auto -o " + out + "/y.mkv")).message ==
          reason + "; a damaged recording is no footage");
  }
}

TEST_CASE("pictures and videos of one folder do not make one clip") {
  const std::string folder =
      write_bracket("import_mixed", std::vector<std::string>(9), std::vector<std::string>(9));
  REQUIRE(test::write_video(folder + "/x.mp4", VideoCodec::H264, pictures(filmed(0, 3, {}))).ok());
  const auto mixed = import_verb(folder + " --list");
  CHECK(sample::error_of(mixed).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(mixed).message, Contains("IMG_0.JPG") && Contains("x.mp4"));
}

TEST_CASE("a frame rate that no recording can have is refused") {
  for (const char* rate : {"1e9", "1e-9", "nan", "0", "-30", "fast"})
    CHECK_THROWS_AS(import_verb(fmt::format("x.png --list --framerate {}", rate)), CLI::ValidationError);
}

TEST_CASE("flags that would not be heeded are refused") {
  const std::string folder = sample::scratch_folder("import_flags"), path = folder + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(filmed(0, 12, {}))).ok());
  CHECK(sample::error_of(import_verb(path + " --gain 2 --list")).code == ErrorCode::Invalid);
  const auto estimated = import_verb(path + " --gain 1,2,4 --shutter auto --list");
  CHECK(sample::error_of(estimated).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(estimated).message, Contains("leave out --gain"));
  for (const std::string& writes : {" -o " + folder + "/y.mkv", std::string(" --force")}) {
    const auto list = import_verb(path + " --shutter 1ms,4ms,16ms --list" + writes);
    CHECK(sample::error_of(list).code == ErrorCode::Invalid);
    CHECK_THAT(sample::error_of(list).message, Contains("leave it out, or --output and --force"));
  }
  const auto outside = import_verb(path + " --shutter 1ms,4ms,16ms --list --allow-outside");
  CHECK(sample::error_of(outside).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(outside).message,
             Contains("no clip.json") && Contains("leave out --allow-outside"));
  std::ofstream(folder + "/clip.json") << "{}";
  const auto clip = import_verb(folder + " --shutter 1ms,4ms,16ms -o " + folder + "/y.mkv");
  CHECK(sample::error_of(clip).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(clip).message, Contains("leave out --shutter"));
}

TEST_CASE("--list writes nothing, and an import never takes the place of its footage") {
  const std::string folder = sample::scratch_folder("import_list"), path = folder + "/x.mkv";
  REQUIRE(test::write_video(path, VideoCodec::Hevc, pictures(filmed(0, 12, {}))).ok());
  CHECK(import_verb(path + " --shutter 1ms,4ms,16ms --list").ok());
  CHECK(std::distance(std::filesystem::directory_iterator(folder), {}) == 1);
  const auto same = import_verb(path + " --shutter 1ms,4ms,16ms --force -o " + path);
  CHECK(sample::error_of(same).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(same).message, Contains("overwrite"));
  CHECK(sample::error_of(import_verb(path + " --shutter 1ms,4ms,16ms")).code == ErrorCode::Invalid);
}

TEST_CASE("--list shows the cycle that EXIF states by its times and gains, not by their products") {
  const std::string folder = sample::scratch_folder("import_list_exif");
  for (int i = 0; i < 9; ++i)
    test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), scene().frame(i).codes,
                     test::Exif{1u << 2 * (i % 3), 1000, 400, 80});
  const test::Ran listed = test::ran({"import", folder, "--list"});
  CHECK(listed.exit_code == 0);
  CHECK_THAT(listed.output,
             Contains("a cycle of 1 ms x 4, 4 ms x 4, 16 ms x 4; the first frame is number 1"));
}

TEST_CASE("--list shows estimated exposures as ratios, and warns as the import does") {
  const std::string folder = sample::scratch_folder("import_list_auto");
  REQUIRE(test::write_video(folder + "/x.mp4", VideoCodec::H264, pictures(filmed(0, 36, {}))).ok());
  const test::Ran listed = test::ran({"import", folder + "/x.mp4", "--list", "--shutter", "auto"});
  CHECK(listed.exit_code == 0);
  CHECK_THAT(listed.output, Contains("exposures: estimated, relative, ") &&
                                Contains(" EV; the first frame is number ") && !Contains(" ms") &&
                                !Contains("warning"));

  test::MovingScene still = scene();
  still.exposures_s = {0.004};
  std::vector<Image<std::uint16_t>> same;
  for (int i = 0; i < 12; ++i) same.push_back(still.frame(i).codes);
  REQUIRE(test::write_video(folder + "/one.mp4", VideoCodec::H264, same).ok());
  const std::vector<std::string> import{"import", folder + "/one.mp4", "--shutter", "auto"};
  for (const std::vector<std::string>& end :
       {std::vector<std::string>{"--list"}, {"-o", folder + "/one.mkv"}}) {
    std::vector<std::string> words = import;
    words.insert(words.end(), end.begin(), end.end());
    CHECK_THAT(test::ran(words).output,
               Contains("warning: all 12 frames have the same exposure and give no HDR"));
  }
}

TEST_CASE(
    "--list of a clip with a clip.json says what it does of footage, and refuses what its import would") {
  const std::string folder = sample::scratch_folder("import_list_clip"), clip = folder + "/clip";
  auto writer = ImageSequenceWriter::create(posix_storage(), clip, scene().camera()).value();
  for (const int i : filmed(1, 10, {5})) {
    RawFrame frame = scene().frame(i);
    frame.facts.slot = i % 3;
    REQUIRE(writer.append(frame).ok());
  }
  REQUIRE(writer.finish().ok());
  const test::Ran listed = test::ran({"import", clip, "--list"});
  CHECK(listed.exit_code == 0);
  CHECK_THAT(listed.output, Contains("moving scene: PNG, clip.json; 128x96, 9 frames, 30 frames per second; "
                                     "recorded as rgb of 8 bits") &&
                                Contains("1 ms, 4 ms, 16 ms; the first frame is number 2 of the cycle") &&
                                Contains("1 frame is missing, before frame 4") && Contains("  frame   0 ") &&
                                Contains("4 ms\n"));

  std::filesystem::remove(clip + "/ldr/0007.png");
  const test::Ran broken = test::ran({"import", clip, "--list"});
  CHECK(broken.exit_code == 3);
  CHECK_THAT(broken.output, Contains("frame 7") && Contains("0007.png"));
  CHECK(test::ran({"import", clip, "-o", folder + "/x.mkv"}).output == broken.output);
}

TEST_CASE("16-bit pictures whose codes lie in the lower 12 bits are imported with a warning") {
  const std::string clip = sample::scratch_folder("import_low_codes");
  std::string frames;
  for (int i = 0; i < 6; ++i) {
    PngImage image{16, Image<std::uint16_t>(1, 48, 64)};
    for (int at = 0; at < 48 * 64; ++at)
      image.samples.samples()[static_cast<std::size_t>(at)] =
          static_cast<std::uint16_t>(std::min(4095, (at % 64 + 1) * (8 << (2 * (i % 3)))));
    REQUIRE(write_png(posix_storage(), clip + fmt::format("/{}.png", i), image).ok());
    frames += fmt::format(R"({}{{"file":"{}.png","time_s":{},"exposure_s":{}}})", i > 0 ? "," : "", i,
                          i / 30.0, 0.001 * (1 << (2 * (i % 3))));
  }
  std::ofstream(clip + "/clip.json") << R"({"width":64,"height":48,"fps":30,"bits":16,"frames":[)" << frames
                                     << "]}";
  for (const std::vector<std::string>& end : {std::vector<std::string>{"--list"}, {"-o", clip + "/x.mkv"}}) {
    std::vector<std::string> words{"import", clip};
    words.insert(words.end(), end.begin(), end.end());
    const test::Ran imported = test::ran(words);
    CHECK(imported.exit_code == 0);
    CHECK_THAT(imported.output, Contains("warning: no code of 16 bits is above 4095") &&
                                    Contains("shift them up by 4 (docs/recording.md, Bits)"));
  }
}
