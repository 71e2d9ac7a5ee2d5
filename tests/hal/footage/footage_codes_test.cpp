// The codes of pictures of other cameras: as their files have them, whatever the kind of file.
#include "hal/footage/footage.h"

#include <png.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <tuple>

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
using test::tiff_file;

namespace {

// The rows and columns in the order of Adam7.
void write_interlaced_png(const std::string& path, const Image<std::uint16_t>& rgb) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  REQUIRE(file != nullptr);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(rgb.cols()), static_cast<png_uint_32>(rgb.rows()), 8,
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_ADAM7, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  std::vector<std::vector<png_byte>> rows;
  std::vector<png_bytep> lines;
  for (int y = 0; y < rgb.rows(); ++y) {
    std::vector<png_byte>& row = rows.emplace_back();
    for (int x = 0; x < rgb.cols(); ++x)
      for (int c = 0; c < 3; ++c) row.push_back(static_cast<png_byte>(rgb.at(c, y, x)));
    lines.push_back(row.data());
  }
  png_write_info(png, info);
  png_write_image(png, lines.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

}  // namespace

TEST_CASE("a video of eight bits comes as RGB of ten, its frames within a code of what was filmed") {
  const std::string path = sample::scratch_folder("footage_h264") + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(5)).ok());
  const ReadFootage read_back = read_footage({path});
  REQUIRE_FALSE(read_back.error);
  CHECK(read_back.about == "h264, yuv420p");
  CHECK(read_back.camera.bits == 10);
  CHECK(read_back.camera.layout == PixelLayout::Rgb);
  CHECK_FALSE(read_back.camera.linear);
  CHECK(read_back.camera.framerate_hz == Approx(30));
  REQUIRE(read_back.frames.size() == 5);
  for (int i = 0; i < 5; ++i) {
    const RawFrame& frame = read_back.frames[static_cast<std::size_t>(i)];
    CHECK(difference(frame, 10, patches(i)) < 3);  // limited range, rounded, and the codec
    CHECK(frame.facts.timestamp.seconds() == Approx(i / 30.0).margin(1e-6));
    CHECK(frame.facts.sequence == static_cast<std::uint64_t>(i));
    CHECK(frame.facts.exposure_source == ExposureSource::Unknown);
  }
}

TEST_CASE("a video that states no matrix is BT.601 up to 576 rows of less than 1280 pixels, else BT.709") {
  const std::string path = sample::scratch_folder("footage_untagged") + "/x.y4m";
  constexpr double kRed601 = 1.1644 * (128 - 16) + 1.5960 * (180 - 128),
                   kRed709 = 1.1644 * (128 - 16) + 1.7927 * (180 - 128);
  for (const auto& [width, height, red] :
       {std::tuple(64, 576, kRed601), {1278, 4, kRed601}, {64, 578, kRed709}, {1280, 4, kRed709}}) {
    const auto pixels = static_cast<std::size_t>(width * height);
    std::ofstream(path, std::ios::binary)
        << fmt::format("YUV4MPEG2 W{} H{} F30:1 Ip A1:1 C444\nFRAME\n", width, height)
        << std::string(pixels, '\x80') << std::string(pixels, '\x80') << std::string(pixels, '\xb4');
    const ReadFootage untagged = read_footage({path});
    INFO(width << "x" << height);
    REQUIRE(untagged.frames.size() == 1);
    CHECK(untagged.frames.front().codes.at(0, 1, 1) / 1023.0 * 255 == Approx(red).margin(0.2));
  }
}

TEST_CASE("HEVC of ten bits keeps its depth, and a variable frame rate its times") {
  const std::string path = sample::scratch_folder("footage_hevc") + "/x.mkv";
  const std::vector<double> times{0, 0.033, 0.08, 0.1, 0.25};
  REQUIRE(test::write_video(path, VideoCodec::Hevc, pictures(5), times).ok());
  const ReadFootage read_back = read_footage({path});
  REQUIRE_FALSE(read_back.error);
  CHECK(read_back.camera.bits == 10);
  REQUIRE(read_back.frames.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(difference(read_back.frames[i], 10, patches(static_cast<int>(i))) < 2);
    CHECK(read_back.frames[i].facts.timestamp.seconds() == Approx(times[i]).margin(1e-3));
  }
}

TEST_CASE("PNG pictures keep every code, eight or sixteen bits, colour or grey") {
  const std::string folder = sample::scratch_folder("footage_png");
  for (const int bits : {8, 16}) {
    Image<std::uint16_t> rgb = patches(0, 33, 47);
    if (bits == 16)
      for (auto& code : rgb.samples()) code = static_cast<std::uint16_t>(code * 257 - (code > 0 ? 1 : 0));
    const ReadFootage colour =
        read_footage({png_file(folder + "/a.png", rgb, bits), png_file(folder + "/b.png", rgb, bits)}, 25);
    REQUIRE_FALSE(colour.error);
    CHECK(colour.camera.bits == bits);
    CHECK(colour.camera.framerate_hz == Approx(25));
    REQUIRE(colour.frames.size() == 2);
    CHECK(sample::same(colour.frames[0].codes, rgb));
    CHECK(colour.frames[1].facts.timestamp.seconds() == Approx(0.04));
    Image<std::uint16_t> grey(1, 33, 47);
    std::copy_n(rgb.plane(0), rgb.plane_size(), grey.plane(0));
    const ReadFootage mono = read_footage({png_file(folder + "/c.png", grey, bits)});
    REQUIRE_FALSE(mono.error);
    CHECK(mono.camera.layout == PixelLayout::Mono);
    CHECK(sample::same(mono.frames[0].codes, grey));
  }
}

TEST_CASE("a PNG that is stored in the order of Adam7 is no interlaced video") {
  const std::string path = sample::scratch_folder("footage_adam7") + "/a.png";
  write_interlaced_png(path, patches(1, 33, 47));
  const ReadFootage read_back = read_footage({path});
  REQUIRE_FALSE(read_back.error);
  REQUIRE(read_back.frames.size() == 1);
  CHECK(sample::same(read_back.frames[0].codes, patches(1, 33, 47)));
}

TEST_CASE("TIFF pictures keep every code, whatever else their tags say") {
  const std::string path = sample::scratch_folder("footage_tiff") + "/a.tif";
  Image<std::uint16_t> rgb = patches(2, 33, 47);
  for (auto& code : rgb.samples()) code = static_cast<std::uint16_t>(code * 257 - (code > 0 ? 1 : 0));
  const ReadFootage read_back = read_footage({tiff_file(path, rgb)});
  REQUIRE_FALSE(read_back.error);
  CHECK(read_back.camera.bits == 16);
  REQUIRE(read_back.frames.size() == 1);
  CHECK(sample::same(read_back.frames[0].codes, rgb));
}

TEST_CASE("a TIFF of floating point is refused for its kind, not only called damaged") {
  const std::string path = sample::scratch_folder("footage_float_tiff") + "/a.tif";
  std::string bytes = read_whole(posix_storage(), tiff_file(path, patches(0))).value();
  const std::string bits("\x10\0\x10\0\x10\0", 6);
  REQUIRE(bytes.find(bits) != std::string::npos);
  bytes.replace(bytes.find(bits), bits.size(), std::string("\x20\0\x20\0\x20\0", 6));
  std::ofstream(path, std::ios::binary) << bytes;
  const ReadFootage read_back = read_footage({path});
  REQUIRE(read_back.error);
  CHECK_THAT(read_back.error->message, Contains("of a kind that FFmpeg does not know") ||  // before FFmpeg 6
                                           Contains("has pixels of the format rgbf32"));
}

TEST_CASE("pictures that are to be turned for display stay as the sensor saw them, and are told") {
  const std::string folder = sample::scratch_folder("footage_turned");
  const auto turned = [](const std::string& path) {
    const auto footage = open_footage(posix_storage(), {path}, 0);
    REQUIRE(footage.ok());
    CHECK(footage.value()->camera().width == 96);
    return footage.value()->turned();
  };
  test::Exif exif;
  for (const std::uint16_t orientation : {std::uint16_t{1}, std::uint16_t{6}, std::uint16_t{8}}) {
    exif.orientation = orientation;
    test::write_jpeg(folder + "/a.jpg", patches(0), exif);
    CHECK(turned(folder + "/a.jpg") == (orientation != 1));
  }
  const std::string video = folder + "/x.mp4";
  REQUIRE(test::write_video(video, VideoCodec::H264, pictures(3)).ok());
  CHECK_FALSE(turned(video));
  std::string bytes = test::text_of(video);
  const std::size_t header = bytes.find("tkhd"), matrix = header + 44;  // ISO/IEC 14496-12, 8.3.2, version 0
  REQUIRE(header != std::string::npos);
  REQUIRE(bytes[header + 4] == 0);
  bytes.replace(matrix, 16, std::string("\0\0\0\0\0\1\0\0\0\0\0\0\xff\xff\0\0", 16));
  bytes.replace(matrix + 16, 4, std::string(4, '\0'));
  std::ofstream(video, std::ios::binary) << bytes;
  CHECK(turned(video));
}
