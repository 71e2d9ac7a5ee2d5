// Footage of other cameras becomes a recording, as the user calls it.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "firmware_host/footage/footage_plan.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/png_image.h"
#include "tests/support/dng_file.h"
#include "tests/support/ran.h"
#include "tests/support/stored_as.h"

#include "tests/support/png_exif.h"

#include "tests/firmware_host/commands/footage_imports.h"

using namespace hdrcam;
using Catch::Contains;
using test::check_labels;
using test::filmed;
using test::import_verb;
using test::pictures;
using test::scene;
using test::times_in;
using test::write_bracket;

namespace {

// What import says of a folder that it takes: where it lists it, and where it writes a recording.
std::vector<std::string> outputs_of_import(const std::string& folder) {
  std::vector<std::string> outputs;
  for (const std::vector<std::string>& end :
       {std::vector<std::string>{"--list"}, {"-o", folder + "/x.mkv"}}) {
    std::vector<std::string> words{"import", folder};
    words.insert(words.end(), end.begin(), end.end());
    const test::Ran imported = test::ran(words);
    CHECK(imported.exit_code == 0);
    outputs.push_back(imported.output);
  }
  return outputs;
}

// A bracket whose pictures are stored as EXIF's orientation of each says.
std::string write_oriented_bracket(const std::string& name, const std::vector<std::uint16_t>& orientations) {
  const std::string folder = sample::scratch_folder(name);
  for (int i = 0; i < static_cast<int>(orientations.size()); ++i) {
    test::Exif exif{1u << 2 * (i % 3), 1000, 100, 80};
    exif.orientation = orientations[static_cast<std::size_t>(i)];
    test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i),
                     test::stored_as(exif.orientation, scene().frame(i).codes), exif);
  }
  return folder;
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

TEST_CASE("footage that needs more memory than is allowed is refused before all of it is read") {
  const std::string folder = sample::scratch_folder("import_memory");
  test::write_jpeg(folder + "/a.jpg", scene().frame(0).codes, test::Exif{});
  std::ofstream(folder + "/b.jpg") << "no picture\n";
  const auto refused = import_verb(folder + " --memory 64 -o " + folder + "/x.mkv");
  CHECK(sample::error_of(refused).code == ErrorCode::Unsupported);
  CHECK_THAT(sample::error_of(refused).message, Contains("--memory"));
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

TEST_CASE("a recording of stills has the camera that all of them state, else none, and no name of a file") {
  const auto name_of = [](const std::vector<std::string>& models) {
    const std::string folder = sample::scratch_folder("import_model"), out = folder + "/x.mkv";
    for (std::size_t i = 0; i < models.size(); ++i) {
      test::Exif exif{1u << 2 * (i % 3), 1000, 100, 80};
      exif.model = models[i];
      test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), scene().frame(static_cast<int>(i)).codes,
                       exif);
    }
    REQUIRE(import_verb(folder + " -o " + out).ok());
    return open_recording(posix_storage(), out).value()->camera().name;
  };
  CHECK(name_of({"EOS R5", "EOS R5", "EOS R5", "EOS R5", "EOS R5", "EOS R5"}) == "EOS R5");
  CHECK(name_of({"EOS R5", "EOS R5", "EOS R5", "EOS R5", "EOS R5", ""}).empty());
  CHECK(name_of({"", "EOS R5", "EOS R5", "EOS R5", "EOS R5", "EOS R5"}).empty());
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
    "a sensitivity or an f-number that some files leave out is not guessed; one that all leave out does not "
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

TEST_CASE("of cut footage what is there is imported, and the end says how much is missing") {
  const std::string path = sample::scratch_folder("import_cut") + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(filmed(0, 30, {}))).ok());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const auto imported = import_verb(path + " -o " + path + ".mkv --shutter 1ms,4ms,16ms");
  CHECK(sample::error_of(imported).code == ErrorCode::Truncated);
  CHECK_THAT(sample::error_of(imported).message, Contains(path) && Contains("missing; the others are used"));
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
  CHECK_THAT(sample::error_of(other).message,
             Contains("frame 9 of '" + request.files[0] + "' is another one"));
}

TEST_CASE("a damaged still ends the import, and nothing is written") {
  const std::string folder = write_bracket("import_damaged");
  const std::string damaged = folder + "/IMG_5.JPG", out = folder + "/x.mkv";
  std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) / 2);
  const auto refused = import_verb(folder + " -o " + out);
  CHECK(sample::error_of(refused).code == ErrorCode::Corrupt);
  CHECK_THAT(sample::error_of(refused).message, Contains(damaged));
  CHECK_FALSE(std::filesystem::exists(out));
}

TEST_CASE("a link in a folder whose file is not there is left out and named") {
  const std::string folder = write_bracket("import_links");
  const std::string out = sample::scratch_folder("import_links_out") + "/x.mkv";
  std::filesystem::create_symlink(folder + "/gone", folder + "/IMG_9.JPG");
  const test::Ran one = test::ran({"import", folder, "-o", out});
  CHECK(one.exit_code == 0);
  CHECK_THAT(one.output,
             Contains("note: '" + folder + "/IMG_9.JPG' is left out: a link whose file is not there"));
  check_labels(out, filmed(0, 9, {}));
  std::filesystem::create_symlink(folder + "/gone", folder + "/IMG_10.JPG");
  CHECK_THAT(test::ran({"import", folder, "--list"}).output,
             Contains("/IMG_9.JPG' and 1 more are left out: "));
}

TEST_CASE("a recording is no footage: in a folder it is left out, by its name it is refused") {
  const std::string folder = write_bracket("import_own");
  REQUIRE(import_verb(folder + " -o " + folder + "/new.mkv").ok());
  const std::string out = sample::scratch_folder("import_own_out") + "/x.mkv";
  REQUIRE(import_verb(folder + " -o " + out).ok());
  check_labels(out, filmed(0, 9, {}));
  const auto again = import_verb(folder + "/new.mkv --shutter auto -o " + out + ".mkv");
  CHECK(sample::error_of(again).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(again).message, Contains("new.mkv' is a recording already"));
}

TEST_CASE("a recording that is cut or damaged before its first frame is called so, and is no footage") {
  const std::string folder = write_bracket("import_stub");
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
          reason + "; a damaged recording is not footage");
  }
}

TEST_CASE("pictures of a camera that was held otherwise are recorded upright, and import says how") {
  const std::string folder = write_oriented_bracket("import_upright", {6, 6, 6, 6, 6, 6});
  for (const std::string& output : outputs_of_import(folder)) {
    CHECK_THAT(output, Contains("note: the pictures are turned by 90 degrees, as the files state\n"));
    CHECK_THAT(output, Contains("128x96") && !Contains("contradict"));
  }
  const auto recorded = sample::replay(posix_storage(), folder + "/x.mkv");
  REQUIRE(recorded.frames.size() == 6);
  CHECK(recorded.frames[0].codes.cols() == 128);
}

TEST_CASE("a recording of pictures that were turned keeps that, and a run refuses to correct its rows") {
  const std::pair<std::uint16_t, bool> turned_by[] = {{1, false}, {2, false}, {3, true}, {6, true}};
  for (const auto& [last, turned] : turned_by) {
    CAPTURE(last);
    const std::uint16_t first = last == 6 ? 6 : 1;  // all have one size once they are upright
    const std::string folder =
        write_oriented_bracket("import_rows", {first, first, first, first, first, last});
    const std::string recording = folder + "/x.mkv";
    REQUIRE(import_verb(folder + " -o " + recording).ok());
    const auto reader = open_recording(posix_storage(), recording);
    REQUIRE(reader.ok());
    CHECK(reader.value()->camera().turned_upright == turned);
    if (!turned) continue;
    const test::Ran replayed =
        test::ran({"replay", recording, "-o", folder + "/%04d.exr", "--readout", "10ms"});
    CHECK(replayed.exit_code != 0);
    CHECK_THAT(replayed.output, Contains("--readout") && Contains("were turned when they were imported"));
  }
}

TEST_CASE("images of a clip.json stay as they are stored, and import says so where they state otherwise") {
  const std::string folder = sample::scratch_folder("import_clip_turned"), first = folder + "/ldr/0000.png";
  auto clip = value_of(ImageSequenceWriter::create(posix_storage(), folder, scene().camera()));
  for (int i = 0; i < 6; ++i) require_done(clip.append(scene().frame(i)));
  require_done(clip.finish());
  for (const std::string& output : outputs_of_import(folder)) CHECK_THAT(output, !Contains("to be shown"));
  std::filesystem::remove(folder + "/x.mkv");
  test::add_exif_to_png(first, 6);
  for (const std::string& output : outputs_of_import(folder))
    CHECK_THAT(output,
               Contains("warning: '" + first +
                        "' states that it is to be shown turned by 90 degrees, which is not applied"));
  const auto recorded = sample::replay(posix_storage(), folder + "/x.mkv");
  REQUIRE(recorded.frames.size() == 6);
  CHECK(recorded.frames[0].codes.cols() == 128);
  CHECK_FALSE(value_of(open_recording(posix_storage(), folder + "/x.mkv"))->camera().turned_upright);
}

TEST_CASE("an orientation that only some pictures state is told wherever in the clip it comes") {
  const std::string folder = write_oriented_bracket("import_turned", {1, 1, 1, 1, 3, 1});
  for (const std::string& output : outputs_of_import(folder)) {
    CHECK_THAT(output, Contains(fmt::format(
                           "note: the pictures are turned as each file states; the first of each "
                           "kind: '{0}/IMG_0.JPG' not turned, '{0}/IMG_4.JPG' turned by 180 degrees\n",
                           folder)));
    CHECK_THAT(output, !Contains("contradict"));
  }
  const std::string mixed = write_oriented_bracket("import_turned_mixed", {6, 6, 6, 6, 6, 6});
  test::write_jpeg(mixed + "/IMG_4.JPG", test::stored_as(6, scene().frame(4).codes),
                   test::Exif{4, 1000, 100, 80});  // all have one size as they are stored
  const auto refused = import_verb(mixed + " --list");
  CHECK(sample::error_of(refused).code == ErrorCode::SizeChanged);
  CHECK_THAT(sample::error_of(refused).message, Contains("IMG_4.JPG"));
}

TEST_CASE("where pictures contradict exposures after a pause, another scene may begin, and import says so") {
  const std::string folder = sample::scratch_folder("import_scenes");
  for (int i = 0; i < 9; ++i) {  // from the fourth on of a scene that is 16 times brighter
    test::Exif exif{1u << 2 * (i % 3), i < 3 ? 1000u : 16000u, 100, 80};
    exif.date_time = i < 3 ? "2026:11:22 17:00:00" : "2026:11:22 17:10:00";
    test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), scene().frame(i).codes, exif);
  }
  const std::string hint = "note: '" + folder + "/IMG_3.JPG' was taken 600 s after the still before it";
  for (const std::string& output : outputs_of_import(folder)) {
    CHECK_THAT(output, Contains("their pictures contradict their exposures") && Contains(hint));
    int named = 0;
    for (int i = 0; i < 9; ++i) {
      const std::string first =
          fmt::format("frame {}, '{}/IMG_{}.JPG': its pictures contradict", i, folder, i);
      if (output.find(first) != std::string::npos) ++named;
    }
    CHECK(named == 1);
  }
}

TEST_CASE("a pattern of numbered pictures, which import does not take, is refused with their folder") {
  const std::string folder = write_bracket("import_pattern");
  const auto pattern = import_verb(folder + "/IMG_%d.JPG --list");
  CHECK(sample::error_of(pattern).code == ErrorCode::NotFound);
  CHECK(sample::error_of(pattern).message ==
        fmt::format("'{0}/IMG_%d.JPG' does not exist; name the files one by one, or their folder, '{0}'",
                    folder));
  CHECK(sample::error_of(import_verb("IMG_%04d.JPG --list")).message.ends_with("or their folder, '.'"));
  CHECK_THAT(sample::error_of(import_verb(folder + "/nope.JPG --list")).message, !Contains("folder,"));
}

TEST_CASE("pictures and videos of one folder do not make one clip") {
  const std::string folder = write_bracket("import_mixed");
  REQUIRE(test::write_video(folder + "/x.mp4", VideoCodec::H264, pictures(filmed(0, 3, {}))).ok());
  const auto mixed = import_verb(folder + " --list");
  CHECK(sample::error_of(mixed).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(mixed).message, Contains("IMG_0.JPG") && Contains("x.mp4"));
}

TEST_CASE("a folder with each still raw and developed is refused with the name of the raw ones") {
  const std::string folder = write_bracket("import_raw_and_jpeg");
  test::DngStill still;
  still.code_at = [](int, int) { return std::uint16_t{1000}; };
  for (int i = 0; i < 9; ++i) test::write_dng(fmt::format("{}/IMG_{}.DNG", folder, i), still);
  const auto both = import_verb(folder + " --list");
  CHECK(sample::error_of(both).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(both).message, Contains("IMG_0.DNG' and '") &&
                                                 Contains("IMG_0.JPG' are a raw still and a developed one") &&
                                                 Contains("such as " + folder + "/*.DNG"));
}

TEST_CASE("a wrong cycle is refused before the footage is read, and one picture alone is no clip") {
  const std::string folder = write_bracket("import_hasty");
  std::ofstream(folder + "/IMG_8.JPG") << "damaged";
  const auto wrong = import_verb(folder + " --shutter 1ms,4 --list");
  CHECK(sample::error_of(wrong).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(wrong).message, Contains("'4' has no unit"));
  const auto long_cycle = import_verb(folder + " --shutter 1ms,2ms,4ms,8ms,16ms --list");
  CHECK(sample::error_of(long_cycle).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(long_cycle).message,
             Contains("1 to 4 exposures, not 5") && Contains("clip.json that states the exposure of each"));
  const auto alone = import_verb(folder + "/IMG_0.JPG --list");
  CHECK(sample::error_of(alone).code == ErrorCode::TooShort);
  CHECK_THAT(sample::error_of(alone).message,
             Contains(folder + "/IMG_0.JPG' holds 1 frame") && Contains("name more files"));
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
    CHECK_THAT(sample::error_of(list).message, Contains("leave out --list, or --output and --force"));
  }
  const auto outside = import_verb(path + " --shutter 1ms,4ms,16ms --list --allow-outside");
  CHECK(sample::error_of(outside).code == ErrorCode::Invalid);
  CHECK_THAT(sample::error_of(outside).message,
             Contains("neither a clip.json") && Contains("leave out --allow-outside"));
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

TEST_CASE("where nearly black pictures show no cycle, codes in the lower bits of 16 are told as the reason") {
  const std::string folder = sample::scratch_folder("import_low_cycle");
  for (int i = 0; i < 6; ++i) {
    PngImage image{16, Image<std::uint16_t>(1, 48, 64)};
    for (int at = 0; at < 48 * 64; ++at)
      image.samples.samples()[static_cast<std::size_t>(at)] =
          static_cast<std::uint16_t>(std::min(4095, (at % 64 + 1) * 80));
    REQUIRE(write_png(posix_storage(), folder + fmt::format("/{}.png", i), image).ok());
  }
  for (const char* cycle : {"1ms,4ms,16ms", "16ms,1ms"}) {
    const auto refused = import_verb(folder + " --list --shutter " + cycle);
    CHECK(sample::error_of(refused).code == ErrorCode::BadExposure);
    CHECK_THAT(sample::error_of(refused).message,
               Contains("do not alternate") && Contains("; no code of 16 bits is above 4095"));
  }
}

TEST_CASE("where pictures clip below the largest code import notes what a run takes for white") {
  const std::string folder = sample::scratch_folder("import_low_white");
  for (int i = 0; i < 9; ++i) {
    Image<std::uint16_t> codes = scene().frame(i).codes;
    for (std::uint16_t& code : codes.samples()) code = static_cast<std::uint16_t>(code * 240 / 255);
    test::write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), codes,
                     test::Exif{1u << 2 * (i % 3), 1000, 100, 80});
  }
  for (const std::string& output : outputs_of_import(folder))
    CHECK_THAT(output, Contains("note: the pictures clip at 2") && Contains("White level)"));
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
