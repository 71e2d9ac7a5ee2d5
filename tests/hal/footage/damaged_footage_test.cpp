// Footage that was cut or damaged: what is left of it, and what is said of the rest.
#include "hal/footage/footage.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/hal/footage/read_footage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/footage_files.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::difference;
using test::patches;
using test::pictures;
using test::png_file;
using test::read_footage;
using test::ReadFootage;
using test::refusal;
using test::tiff_file;

namespace {

// Motion JPEG at 25 frames per second, as cameras write it.
void write_avi(const std::string& path, const std::vector<Image<std::uint16_t>>& rgb) {
  AVFormatContext* muxer = nullptr;
  REQUIRE(avformat_alloc_output_context2(&muxer, nullptr, "avi", path.c_str()) >= 0);
  AVStream* const track = avformat_new_stream(muxer, nullptr);
  track->codecpar->codec_type = AVMEDIA_TYPE_VIDEO, track->codecpar->codec_id = AV_CODEC_ID_MJPEG;
  track->codecpar->width = rgb[0].cols(), track->codecpar->height = rgb[0].rows();
  track->time_base = {1, 25}, track->avg_frame_rate = {25, 1};
  REQUIRE(avio_open(&muxer->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0);
  REQUIRE(avformat_write_header(muxer, nullptr) >= 0);
  AVPacket* const packet = av_packet_alloc();
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    test::write_jpeg(path + ".jpg", rgb[i], std::nullopt);
    const std::string bytes = test::text_of(path + ".jpg");
    REQUIRE(av_new_packet(packet, static_cast<int>(bytes.size())) >= 0);
    std::copy(bytes.begin(), bytes.end(), packet->data);
    packet->pts = packet->dts = static_cast<std::int64_t>(i), packet->duration = 1;
    packet->flags |= AV_PKT_FLAG_KEY;
    REQUIRE(av_write_frame(muxer, packet) >= 0);
    av_packet_unref(packet);
  }
  av_packet_free(const_cast<AVPacket**>(&packet));
  REQUIRE(av_write_trailer(muxer) >= 0);
  avio_closep(&muxer->pb);
  avformat_free_context(muxer);
}

// A video of 20 pictures, a tenth of its bytes zeros.
void write_damaged(const std::string& path) {
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(20)).ok());
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path));
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const std::string zeros(static_cast<std::size_t>(size / 10), '\0');
  file.seekp(size / 2).write(zeros.data(), static_cast<std::streamsize>(zeros.size()));
}

}  // namespace

TEST_CASE("a video that was cut comes up to its cut") {
  const std::string path = sample::scratch_folder("footage_cut") + "/x.mkv";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(90)).ok());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) * 3 / 4);
  const ReadFootage read_back = read_footage({path});
  CHECK_FALSE(read_back.error);
  CHECK(read_back.frames.size() >= 30);
  CHECK(read_back.frames.size() < 90);
  REQUIRE(read_back.losses.size() == 1);  // its end is stated
  CHECK(static_cast<int>(read_back.frames.size()) + read_back.losses[0].lost.missing == 90);
}

TEST_CASE("an MP4 that was cut before its index is called one, and not a file that nobody knows") {
  const std::string path = sample::scratch_folder("footage_no_index") + "/x.mp4";
  const std::string type("\0\0\0\30ftypisom\0\0\2\0isomiso2", 24), samples("\0\1\0\0mdat", 8);
  std::ofstream(path, std::ios::binary) << type << samples << std::string(1000, '\0');
  const ReadFootage cut = read_footage({path});
  CHECK_THAT(refusal(cut, ErrorCode::NotRecording),
             Contains(path) && Contains("one that was cut has lost its index"));
}

TEST_CASE("an MP4 that was cut within its index, which stands first, is called cut") {
  const std::string path = sample::scratch_folder("footage_cut_in_index") + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(3)).ok());
  const std::string whole = test::text_of(path);
  const std::size_t index = whole.find("moov");
  REQUIRE(index < 64);
  for (std::size_t behind = 8; index + behind < whole.find("moof") - 8; behind += 40) {
    CAPTURE(behind);
    std::ofstream(path, std::ios::binary) << whole.substr(0, index + behind);
    const ReadFootage cut = read_footage({path});
    REQUIRE(cut.error);
    CHECK((cut.error->code == ErrorCode::Truncated || cut.error->code == ErrorCode::NotRecording));
    CHECK_THAT(cut.error->message, Contains("is an MP4 or MOV that") && Contains("index"));
  }
}

TEST_CASE("a HEIC picture that FFmpeg cannot read is called one, and not a video that was cut") {
  const std::string path = sample::scratch_folder("footage_heic") + "/IMG_1.HEIC";
  const std::string type("\0\0\0\30ftypheic\0\0\0\0mif1heic", 24), samples("\0\1\0\0mdat", 8);
  std::ofstream(path, std::ios::binary) << type << samples << std::string(1000, '\0');
  const ReadFootage picture = read_footage({path});
  CHECK_THAT(refusal(picture, ErrorCode::NotRecording),
             Contains(path) && Contains("HEIC") && !Contains("cut"));
}

TEST_CASE("what a cut AVI lacks is counted by the number of frames that its head states") {
  const std::string path = sample::scratch_folder("footage_cut_avi") + "/x.avi";
  write_avi(path, pictures(24));
  const ReadFootage whole = read_footage({path});
  CHECK(whole.losses.empty());
  CHECK(whole.frames.size() == 24);
  const auto size = std::filesystem::file_size(path);
  for (const double share : {0.9, 0.6, 0.3}) {
    CAPTURE(share);
    std::filesystem::resize_file(path, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
    const ReadFootage cut = read_footage({path});
    CHECK_FALSE(cut.error);
    REQUIRE(cut.losses.size() == 1);
    CHECK(cut.losses[0].lost.missing > 0);
    CHECK(static_cast<int>(cut.frames.size()) + cut.losses[0].lost.missing + cut.losses[0].lost.damaged ==
          24);
  }
}

TEST_CASE("a Y4M that ends inside a frame was cut, and one that ends behind a frame was not") {
  const std::string path = sample::scratch_folder("footage_cut_y4m") + "/x.y4m";
  constexpr int kFrames = 3;
  {
    std::ofstream file(path, std::ios::binary);
    file << "YUV4MPEG2 W32 H32 F30:1 Ip A1:1 C444\n";
    for (int i = 0; i < kFrames; ++i) file << "FRAME\n" << std::string(3 * 32 * 32, '\x80');
  }
  const ReadFootage whole = read_footage({path});
  CHECK(whole.losses.empty());
  CHECK(whole.frames.size() == kFrames);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1000);
  const ReadFootage cut = read_footage({path});
  CHECK_FALSE(cut.error);
  CHECK(cut.frames.size() == kFrames - 1);
  REQUIRE(cut.losses.size() == 1);
  CHECK(cut.losses[0].lost.missing == 1);
}

TEST_CASE("a Y4M that ends inside its first frame is called cut, and one without a frame holds no pictures") {
  const std::string path = sample::scratch_folder("footage_cut_first_y4m") + "/x.y4m";
  const std::string head = "YUV4MPEG2 W32 H32 F30:1 Ip A1:1 C444\n";
  std::ofstream(path, std::ios::binary) << head << "FRAME\n" << std::string(3 * 32 * 32, '\x80');
  for (const std::size_t behind_head : {std::size_t{1000}, std::size_t{6}, std::size_t{3}}) {
    CAPTURE(behind_head);
    std::filesystem::resize_file(path, head.size() + behind_head);
    const ReadFootage cut = read_footage({path});
    CHECK_THAT(refusal(cut, ErrorCode::Truncated), Contains("x.y4m' ends before the end of its first frame"));
  }
  std::filesystem::resize_file(path, head.size());
  const ReadFootage none = read_footage({path});
  CHECK_THAT(refusal(none, ErrorCode::NotRecording), Contains("holds no pictures"));
}

TEST_CASE("a Matroska video that ends inside its first frame is called cut") {
  const std::string path = sample::scratch_folder("footage_cut_first_mkv") + "/x.mkv";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(3)).ok());
  const std::size_t cluster = test::text_of(path).find("\x1f\x43\xb6\x75");
  REQUIRE(cluster != std::string::npos);
  std::filesystem::resize_file(path, cluster + 40);
  const ReadFootage cut = read_footage({path});
  CHECK_THAT(refusal(cut, ErrorCode::Truncated), Contains("x.mkv' ends before the end of its first frame"));
}

TEST_CASE("what a cut video lacks is counted, and a whole one lacks nothing") {
  const std::string path = sample::scratch_folder("footage_cut_mp4") + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(30)).ok());
  CHECK(read_footage({path}).losses.empty());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const ReadFootage read_back = read_footage({path, path});
  CHECK_FALSE(read_back.error);
  REQUIRE(read_back.losses.size() == 2);
  const PictureLosses lost = read_back.losses[0].lost;
  CHECK(read_back.losses[0].path == path);
  CHECK(lost.missing > 0);
  const std::size_t whole = read_back.frames.size() / 2;
  CHECK(whole + static_cast<std::size_t>(lost.missing + lost.damaged) == 30);
  // The second file begins where the first one should have ended, but for its last, damaged picture.
  const double begin_s = read_back.frames[whole].facts.timestamp.seconds();
  CHECK(begin_s >= static_cast<double>(30 - lost.damaged) / 30 - 1e-6);
}

TEST_CASE("a duration that was copied from the file before is not what a whole video lacks") {
  const std::string folder = sample::scratch_folder("footage_stale_duration");
  REQUIRE(test::write_video(folder + "/x.mkv", VideoCodec::H264, pictures(10)).ok());
  REQUIRE(test::remux(folder + "/x.mkv", folder + "/x.nut", "nut", "00:01:00.000000000").ok());
  const ReadFootage read_back = read_footage({folder + "/x.nut"});
  REQUIRE_FALSE(read_back.error);
  CHECK(read_back.frames.size() == 10);
  CHECK(read_back.losses.empty());
}

TEST_CASE("a video that states an impossible end puts no frame of the next one beyond all times") {
  const std::string folder = sample::scratch_folder("footage_endless");
  for (const char* name : {"/a.mkv", "/b.mkv"})
    REQUIRE(test::write_video(folder + name, VideoCodec::H264, pictures(3), {}, 0.01).ok());
  std::ifstream whole(folder + "/a.mkv", std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(whole), {});
  const std::string stated = "00:05:00.000000000", claimed = "9999999999:59:59.0";
  const std::size_t at = bytes.find(stated);
  REQUIRE(at != std::string::npos);
  bytes.replace(at, stated.size(), claimed);
  std::ofstream(folder + "/a.mkv", std::ios::binary) << bytes;
  const ReadFootage read_back = read_footage({folder + "/a.mkv", folder + "/b.mkv"});
  CHECK_THAT(refusal(read_back, ErrorCode::Corrupt), Contains("/b.mkv', would come"));
}

TEST_CASE("damaged frames of a video are left out and counted, and the others keep their times") {
  const std::string path = sample::scratch_folder("footage_damaged") + "/x.mp4";
  write_damaged(path);
  const ReadFootage read_back = read_footage({path});
  CHECK_FALSE(read_back.error);
  REQUIRE(read_back.losses.size() == 1);
  CHECK(read_back.losses[0].lost.damaged > 0);
  CHECK(read_back.losses[0].lost.missing == 0);
  CHECK(read_back.frames.size() < 20);
  for (const RawFrame& frame : read_back.frames) {
    const double number = frame.facts.timestamp.seconds() * 30;
    CHECK(number == Approx(std::round(number)).margin(1e-3));
    CHECK(difference(frame, 10, patches(static_cast<int>(std::lround(number)))) < 3);
  }
}

TEST_CASE("a damaged video has the same whole frames whenever it is read") {
  const std::string path = sample::scratch_folder("footage_damaged_again") + "/x.mp4";
  write_damaged(path);
  const auto times = [&] {
    std::vector<double> times_s;
    for (const RawFrame& frame : read_footage({path}).frames)
      times_s.push_back(frame.facts.timestamp.seconds());
    return times_s;
  };
  const std::vector<double> first = times();
  CHECK(first.size() < 20);
  for (int i = 0; i < 8; ++i) CHECK(times() == first);
}

TEST_CASE("a damaged still is an error that names it, wherever it stands") {
  const std::string folder = sample::scratch_folder("footage_damaged_still");
  test::write_jpeg(folder + "/a.jpg", patches(0), std::nullopt);
  test::write_jpeg(folder + "/b.jpg", patches(1), std::nullopt);
  png_file(folder + "/c.png", patches(0)), png_file(folder + "/d.png", patches(1));
  tiff_file(folder + "/e.tif", patches(0)), tiff_file(folder + "/f.tif", patches(1));
  for (const auto& [whole, cut] :
       {std::pair{"/a.jpg", "/b.jpg"}, std::pair{"/c.png", "/d.png"}, std::pair{"/e.tif", "/f.tif"}}) {
    const std::string damaged = folder + cut;
    std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) * 2 / 3);
    for (const auto& files : {std::vector{folder + whole, damaged}, std::vector{damaged, folder + whole}}) {
      const ReadFootage read_back = read_footage(files);
      CHECK_THAT(refusal(read_back, ErrorCode::Corrupt), Contains(damaged) && Contains("damaged or cut"));
    }
  }
}
