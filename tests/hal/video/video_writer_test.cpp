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
