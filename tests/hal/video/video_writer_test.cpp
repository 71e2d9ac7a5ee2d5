#include "hal/video/video_writer.h"

#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/decoded_video.h"
#include "tests/support/footage_files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// Stripes that move, so that frames are predicted from each other.
std::vector<Image<std::uint16_t>> moving_stripes(int count, int rows, int cols) {
  std::vector<Image<std::uint16_t>> pictures;
  for (int i = 0; i < count; ++i) {
    Image<std::uint16_t>& rgb = pictures.emplace_back(3, rows, cols);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x)
          rgb.at(c, y, x) = static_cast<std::uint16_t>((13 * (x + 3 * i) + 7 * y) % 256);
  }
  return pictures;
}

}  // namespace

TEST_CASE("after a pause that the container cannot state the frames keep their distances") {
  const std::string folder = sample::scratch_folder("video_pause");
  const std::vector<double> times{0, 0.04, 3000, 3000.04, 3000.08, 9000};
  for (const auto& [name, longest_s] : {std::pair{"x.mp4", 2000.0}, {"x.mov", 2000.0}, {"x.mkv", 1e9}}) {
    CAPTURE(name);
    const std::string path = folder + "/" + name;
    REQUIRE(test::write_video(path, VideoCodec::H264, moving_stripes(6, 32, 48), times, 25).ok());
    const test::DecodedVideo video = test::decoded_video(path);
    REQUIRE(video.frames.size() == times.size());
    for (std::size_t i = 1; i < times.size(); ++i)
      CHECK(video.frames[i].time_s - video.frames[i - 1].time_s ==
            Approx(std::min(times[i] - times[i - 1], longest_s)).margin(2e-3));
  }
}

TEST_CASE("the times of frames are rounded to microseconds") {
  const std::string path = sample::scratch_folder("video_times") + "/x.mp4";
  std::vector<double> times;
  for (int i = 0; i < 7; ++i) times.push_back(i / 30.0);
  REQUIRE(test::write_video(path, VideoCodec::H264, moving_stripes(7, 32, 48), times).ok());
  const test::DecodedVideo video = test::decoded_video(path);
  REQUIRE(video.frames.size() == times.size());
  for (std::size_t i = 0; i < times.size(); ++i)
    CHECK(video.frames[i].time_s == Approx(times[i]).epsilon(0).margin(5.1e-7));
}

TEST_CASE("a video of a thousand frames a second has its times in Matroska, too") {
  const std::string path = sample::scratch_folder("video_fast") + "/x.mkv";
  const std::vector<double> times{0, 0.001, 0.002, 0.007, 0.008, 0.02};
  REQUIRE(test::write_video(path, VideoCodec::H264, moving_stripes(6, 32, 48), times, 1000).ok());
  const test::DecodedVideo video = test::decoded_video(path);
  REQUIRE(video.frames.size() == times.size());
  for (std::size_t i = 0; i < times.size(); ++i)
    CHECK(video.frames[i].time_s == Approx(times[i]).margin(1e-6));
}

TEST_CASE("of frames within a millisecond no two have one time in Matroska") {
  const std::string path = sample::scratch_folder("video_faster") + "/x.mkv";
  REQUIRE(test::write_video(path, VideoCodec::H264, moving_stripes(9, 32, 48), {}, 3000).ok());
  const test::DecodedVideo video = test::decoded_video(path);
  REQUIRE(video.frames.size() == 9);
  for (std::size_t i = 1; i < video.frames.size(); ++i)
    CHECK(video.frames[i].time_s > video.frames[i - 1].time_s);
}

TEST_CASE("videos of less than a frame a second have their times, whatever the codec") {
  const std::string folder = sample::scratch_folder("video_slow");
  for (const VideoCodec codec : {VideoCodec::Hevc, VideoCodec::Av1, VideoCodec::H264})
    for (const double framerate_hz : {0.5, 0.1}) {
      CAPTURE(static_cast<int>(codec), framerate_hz);
      const std::string path = folder + "/x.mp4";
      REQUIRE(test::write_video(path, codec, moving_stripes(4, 64, 64), {}, framerate_hz).ok());
      const test::DecodedVideo video = test::decoded_video(path);
      REQUIRE(video.frames.size() == 4);
      for (std::size_t i = 0; i < video.frames.size(); ++i)
        CHECK(video.frames[i].time_s == Approx(static_cast<double>(i) / framerate_hz).margin(1e-5));
    }
}

TEST_CASE("pictures smaller than the codec takes are refused with the least size") {
  const std::string folder = sample::scratch_folder("video_tiny");
  for (const auto& [rows, cols] : {std::pair{8, 8}, {14, 64}, {64, 14}}) {
    CAPTURE(rows, cols);
    const std::string size = fmt::format("{}x{}", cols, rows);
    const auto refused =
        test::write_video(folder + "/" + size + ".mp4", VideoCodec::Hevc, moving_stripes(2, rows, cols));
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::Unsupported);
    CHECK_THAT(refused.error().message, Catch::Contains("smaller than 16x16, and these are " + size));
  }
  CHECK(test::write_video(folder + "/av1.mp4", VideoCodec::Av1, moving_stripes(2, 8, 8)).ok());
}

TEST_CASE("HEVC videos of narrow pictures have all their frames, and the encoder keeps to its memory") {
  const std::string folder = sample::scratch_folder("video_narrow");
  const struct { int rows, cols; } sizes[] = {{16, 16}, {34, 34}, {200, 18}, {64, 48}};
  for (const auto& size : sizes) {
    CAPTURE(size.rows, size.cols);
    const std::string path = fmt::format("{}/{}x{}.mp4", folder, size.cols, size.rows);
    REQUIRE(test::write_video(path, VideoCodec::Hevc, moving_stripes(12, size.rows, size.cols)).ok());
    const test::DecodedVideo video = test::decoded_video(path);
    CHECK(video.codec == "hevc");
    CHECK(video.frames.size() == 12);
  }
}
