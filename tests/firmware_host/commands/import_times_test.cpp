// When the frames of footage are, as their files say it or the user, and what is missing between them.
#include <filesystem>
#include <fstream>

#include "firmware_host/footage/described_plan.h"
#include "firmware_host/footage/footage_plan.h"
#include "hal/recording/png_image.h"
#include "tests/support/ran.h"

#include "tests/firmware_host/commands/footage_imports.h"

using namespace hdrcam;
using Catch::Contains;
using test::check_labels;
using test::filmed;
using test::import_verb;
using test::pictures;
using test::times_in;
using test::write_bracket;

namespace {

// What `import --list` says of the footage in a folder.
std::string listed(const std::string& folder, FootageOrder order = FootageOrder::Given,
                   double framerate_hz = 0) {
  const std::atomic<bool> stop = false;
  FootageRequest request;
  request.files = footage_in(folder).value();
  request.order = order, request.framerate_hz = framerate_hz;
  const auto plan = plan_footage(posix_storage(), request, stop);
  REQUIRE(plan.ok());
  return described(plan.value());
}

// The green of pictures as Y4M, which states a rate and no times.
void write_y4m(const std::string& path, const std::vector<Image<std::uint16_t>>& rgb) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format("YUV4MPEG2 W{} H{} F30:1 Ip A1:1 Cmono\n", rgb[0].cols(), rgb[0].rows());
  for (const Image<std::uint16_t>& picture : rgb) {
    file << "FRAME\n";
    for (std::size_t i = 0; i < picture.plane_size(); ++i) file.put(static_cast<char>(picture.plane(1)[i]));
  }
}

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

// Frames of the scene as motion JPEG in Matroska, 40 ms each, whose pictures state their exposures in EXIF,
// and times that are 70 ms apart.
void write_motion_jpeg(const std::string& path, const std::vector<int>& frames) {
  AVFormatContext* muxer = nullptr;
  REQUIRE(avformat_alloc_output_context2(&muxer, nullptr, "matroska", path.c_str()) >= 0);
  AVStream* const track = avformat_new_stream(muxer, nullptr);
  track->codecpar->codec_type = AVMEDIA_TYPE_VIDEO, track->codecpar->codec_id = AV_CODEC_ID_MJPEG;
  track->codecpar->width = test::scene().cols, track->codecpar->height = test::scene().rows;
  track->time_base = {1, 1000}, track->avg_frame_rate = {25, 1};
  REQUIRE(avio_open(&muxer->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0);
  REQUIRE(avformat_write_header(muxer, nullptr) >= 0);
  const libav::Packet packet(av_packet_alloc());
  for (const int i : frames) {
    const double time_s = test::scene().exposures_s[static_cast<std::size_t>(i) % 3];
    test::Exif exif{static_cast<std::uint32_t>(std::lround(time_s * 1000)), 1000, 100, 80};
    exif.date_time = "2026:11:22 17:00:00", exif.sub_second = fmt::format("{:02}", 7 * i);
    test::write_jpeg(path + ".jpg", test::scene().frame(i).codes, exif);
    const std::string bytes = read_whole(posix_storage(), path + ".jpg").value();
    REQUIRE(av_new_packet(packet.get(), static_cast<int>(bytes.size())) >= 0);
    std::ranges::copy(bytes, packet->data);
    packet->pts = packet->dts = av_rescale_q(40 * i, {1, 1000}, track->time_base);
    packet->flags |= AV_PKT_FLAG_KEY;
    REQUIRE(av_write_frame(muxer, packet.get()) >= 0);
    av_packet_unref(packet.get());
  }
  REQUIRE(av_write_trailer(muxer) >= 0);
  avio_closep(&muxer->pb);
  avformat_free_context(muxer);
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

TEST_CASE("stills of a folder whose numbers begin anew come in the order in which they were taken") {
  const std::string t = "2026:11:22 17:00:";
  const std::vector<std::string> seconds{t + "08", t + "08", t + "08", t + "12", t + "00",
                                         t + "00", t + "04", t + "04", t + "04"};
  const std::string folder =
      write_bracket("import_round", seconds, {"00", "25", "50", "00", "00", "25", "00", "25", "50"});
  const std::string out = sample::scratch_folder("import_round_out") + "/x.mkv";
  // Between neighbours it was the clock that was set back.
  CHECK_THAT(listed(folder, FootageOrder::Numbers),
             Contains("IMG_4.JPG' was taken before '" + folder + "/IMG_3.JPG' by EXIF"));
  std::string named;
  for (int i = 0; i < 9; ++i) {
    const int number = i < 4 ? i : 9990 + i;
    named += fmt::format("{}/IMG_{}.JPG ", folder, number);
    std::filesystem::rename(fmt::format("{}/IMG_{}.JPG", folder, i),
                            fmt::format("{}/IMG_{}.JPG", folder, number));
  }
  const test::Ran imported = test::ran({"import", folder, "-o", out});
  CHECK(imported.exit_code == 0);
  CHECK_THAT(imported.output,
             Contains("note: '" + folder + "/IMG_9994.JPG' is the first frame, as EXIF says"));
  const std::vector<double> expected{0, .25, 4, 4.25, 4.5, 8, 8.25, 8.5, 12};
  const std::vector<double> times = times_in(out);
  REQUIRE(times.size() == 9);
  for (std::size_t i = 0; i < 9; ++i) CHECK(times[i] == Approx(expected[i]).margin(1e-9));
  const auto replayed = sample::replay(posix_storage(), out);
  CHECK(replayed.frames.at(0).facts.exposure_s == Approx(test::scene().exposures_s[4 % 3]));

  // Files that are named come as they are named.
  REQUIRE(import_verb(named + "--force -o " + out).ok());
  CHECK(times_in(out)[1] == Approx(1. / 30).margin(1e-8));
}

TEST_CASE("files that a shell put into another order than that of their numbers are told of") {
  const std::string folder = write_bracket("import_shell_order");
  std::vector<std::string> words{"import", "--list"};
  for (const int i : {0, 1, 2, 3, 4, 5, 6, 7, 8}) words.push_back(fmt::format("{}/IMG_{}.JPG", folder, i));
  CHECK_THAT(test::ran(words).output, !Contains("comes before"));
  std::swap(words[4], words[6]);  // 0 1 4 3 2
  CHECK_THAT(test::ran(words).output,
             Contains(fmt::format("note: '{0}/IMG_4.JPG' comes before '{0}/IMG_3.JPG'", folder)) &&
                 Contains("import their folder"));
}

TEST_CASE("stills whose EXIF resolves seconds only come at the frame rate, and the list says why") {
  const std::string t = "2026:11:22 17:00:0";
  const std::string folder = write_bracket(
      "import_coarse", {t + "0", t + "0", t + "1", t + "1", t + "2", t + "2", t + "3", t + "3", t + "4"});
  const std::string out = sample::scratch_folder("import_coarse_out") + "/x.mkv";
  REQUIRE(import_verb(folder + " -o " + out).ok());
  const std::vector<double> times = times_in(out);
  for (std::size_t i = 0; i < 9; ++i) CHECK(times[i] == Approx(static_cast<double>(i) / 30).margin(1e-8));
  CHECK_THAT(listed(folder),
             Contains("times: at 30 frames per second, because EXIF has times in steps of 1 s") &&
                 Contains("IMG_0.JPG' and '" + folder + "/IMG_1.JPG' are 0 s apart"));
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

TEST_CASE("times in whole milliseconds give the video's frame rate, and no frame for missing") {
  for (const double rate_hz : {24., 60., 120., 480., 720., 950.}) {
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

TEST_CASE("of frames that are missing, only those that the times do not show make them longer") {
  const std::string path = sample::scratch_folder("import_half_shown") + "/x.mkv";
  const std::vector<int> frames = filmed(0, 24, {9, 10});
  std::vector<double> times_s;
  for (const int i : frames) times_s.push_back((i > 10 ? i - 1 : i) / 30.);  // a gap of one of the two
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(frames), times_s).ok());
  const std::atomic<bool> stop = false;
  const auto plan =
      plan_footage(posix_storage(), {.files = {path}, .shutter = "1ms,4ms,16ms", .gain = ""}, stop);
  REQUIRE(plan.ok());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CAPTURE(i);
    CHECK(plan.value().facts[i].sequence == static_cast<std::uint64_t>(frames[i]));
    CHECK(plan.value().facts[i].timestamp.seconds() == Approx(frames[i] / 30.).margin(2e-3));
  }
}

TEST_CASE("of motion JPEG that states its exposures, what its times lack is told, counted and flagged") {
  const std::string folder = sample::scratch_folder("import_motion_jpeg"), out = folder + "/out.mkv";
  const std::vector<int> frames = filmed(0, 12, {4});
  write_motion_jpeg(folder + "/x.mkv", frames);
  const test::Ran imported = test::ran({"import", folder + "/x.mkv", "-o", out});
  INFO(imported.output);
  REQUIRE(imported.exit_code == 0);
  CHECK_THAT(imported.output, Contains("1 frame is missing, before frame 4"));
  check_labels(out, frames);
  const auto replayed = sample::replay(posix_storage(), out);
  for (std::size_t i = 0; i < replayed.frames.size(); ++i)
    CHECK(((replayed.frames[i].facts.flags & kFrameAfterDrop) != 0) == (i == 4));
}

TEST_CASE("the times of a video count before those that EXIF states of its pictures") {
  const std::string folder = sample::scratch_folder("import_motion_jpeg_times"), out = folder + "/out.mkv";
  write_motion_jpeg(folder + "/x.mkv", filmed(0, 9, {}));
  REQUIRE(import_verb(folder + "/x.mkv -o " + out).ok());
  const std::vector<double> times = times_in(out);
  REQUIRE(times.size() == 9);
  for (std::size_t i = 0; i < 9; ++i) CHECK(times[i] == Approx(0.04 * static_cast<double>(i)).margin(1e-9));
}

TEST_CASE("a pause of years is a loss of very many frames") {
  std::vector<double> times_s;
  for (int i = 0; i < 12; ++i) times_s.push_back(i / 30. + (i < 6 ? 0 : 143165576));
  const FootagePlan plan = plan_of_matroska("import_years", times_s, 30);
  CHECK(plan.facts.back().sequence > 1'000'000'000);
  CHECK_THAT(describe_missing(plan), Contains("frames are missing, before frame 6"));
}

TEST_CASE("where a fifth of a named cycle would be missing, and no time shows it, the cycle is doubted") {
  const std::string folder = sample::scratch_folder("import_there_and_back");
  test::MovingScene scene = test::scene();
  scene.exposures_s = {0.001, 0.004, 0.016, 0.004};
  for (int i = 0; i < 16; ++i)
    test::write_jpeg(fmt::format("{}/{:02}.jpg", folder, i), scene.frame(i).codes, std::nullopt);
  const auto listed_with = [&folder](const char* cycle) {
    return test::ran({"import", folder, "--list", "--shutter", cycle}).output;
  };
  CHECK_THAT(listed_with("1ms,4ms,16ms"),
             Contains("frames are missing, before frame ") && Contains("its cycle is another one"));
  CHECK_THAT(listed_with("1ms,4ms,16ms,4ms"), !Contains("missing"));
}

TEST_CASE("stills without any time come at the frame rate, and the list says so") {
  const std::string folder = write_bracket("import_no_times");
  CHECK_THAT(
      listed(folder),
      Contains("times: at 30 frames per second, because none of them states in EXIF when it was taken"));
}

TEST_CASE("a rate of one is told as one frame per second") {
  CHECK_THAT(listed(write_bracket("import_one_a_second"), FootageOrder::Given, 1),
             Contains("9 frames, 1 frame per second; "));
}

TEST_CASE("a frame rate that no recording can have is refused") {
  for (const char* rate : {"1e9", "1e-9", "nan", "0", "-30", "fast"})
    CHECK_THROWS_AS(import_verb(fmt::format("x.png --list --framerate {}", rate)), CLI::ValidationError);
}

TEST_CASE("import says of a clip whose times and rate differ as milliseconds and seconds do that they do") {
  const std::string clip = sample::scratch_folder("import_unlike_rate");
  for (int i = 0; i < 6; ++i)
    REQUIRE(write_png(posix_storage(), fmt::format("{}/{}.png", clip, i), {8, test::scene().frame(i).codes})
                .ok());
  const auto listed_at = [&](double apart_s) {
    std::string frames;
    for (int i = 0; i < 6; ++i)
      frames += fmt::format(R"({}{{"file":"{}.png","time_s":{},"exposure_s":{}}})", i > 0 ? "," : "", i,
                            i * apart_s, test::scene().exposures_s[static_cast<std::size_t>(i) % 3]);
    std::ofstream(clip + "/clip.json")
        << fmt::format(R"({{"width":{},"height":{},"fps":25,"bits":8,"frames":[{}]}})", test::scene().cols,
                       test::scene().rows, frames);
    const test::Ran ran = test::ran({"import", clip, "--list"});
    CHECK(ran.exit_code == 0);
    return ran.output;
  };
  CHECK_THAT(listed_at(40), Contains("note: the frames are 40 s apart by 'time_s' and 0.04 s by 'fps'"));
  CHECK_THAT(listed_at(4e-5), Contains("note: the frames are 4e-05 s apart by 'time_s'"));
  for (const double apart_s : {0.04, 0.2}) CHECK_THAT(listed_at(apart_s), !Contains("apart"));
}
