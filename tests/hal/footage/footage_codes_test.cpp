// The codes of pictures of other cameras: as their files have them, whatever the kind of file.
#include "hal/footage/footage.h"

#include <png.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/hal/footage/read_footage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/footage_files.h"
#include "tests/support/stored_as.h"

#include "tests/support/files.h"
#include "tests/support/png_exif.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::add_exif_to_png;
using test::difference;
using test::patches;
using test::pictures;
using test::png_file;
using test::read_footage;
using test::ReadFootage;
using test::refusal;
using test::stored_as;
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

// Upright, patches(0) and the following ones have this size.
void check_sides(const ReadFootage& read) {
  REQUIRE_FALSE(read.frames.empty());
  CHECK(read.camera.width == 96);
  CHECK(read.camera.height == 64);
  for (const RawFrame& frame : read.frames) {
    REQUIRE(frame.codes.cols() == 96);
    REQUIRE(frame.codes.rows() == 64);
  }
}

void check_upright(const ReadFootage& read, double most) {
  check_sides(read);
  for (std::size_t i = 0; i < read.frames.size(); ++i)
    CHECK(difference(read.frames[i], read.camera.bits, patches(static_cast<int>(i))) < most);
}

// In 65536ths, as MP4 has it: x' = a x + c y, y' = b x + d y.
struct DisplayMatrix {
  std::int32_t a, b, c, d;
};

// Of the track of an MP4 (ISO/IEC 14496-12, 8.3.2, version 0).
void set_display_matrix(const std::string& path, const DisplayMatrix& matrix) {
  std::string bytes = test::text_of(path);
  const std::size_t header = bytes.find("tkhd");
  REQUIRE(header != std::string::npos);
  REQUIRE(bytes[header + 4] == 0);
  std::size_t at = header + 44;
  for (const std::int32_t number : {matrix.a, matrix.b, 0, matrix.c, matrix.d})
    for (const int shift : {24, 16, 8, 0})
      bytes[at++] = static_cast<char>(static_cast<std::uint32_t>(number) >> shift & 0xff);
  std::ofstream(path, std::ios::binary) << bytes;
}

// A raw video of one frame.
void write_mosaic_video(const std::string& path) {
  AVFormatContext* video = nullptr;
  REQUIRE(avformat_alloc_output_context2(&video, nullptr, "nut", path.c_str()) >= 0);
  AVStream* const track = avformat_new_stream(video, nullptr);
  track->codecpar->codec_type = AVMEDIA_TYPE_VIDEO, track->codecpar->codec_id = AV_CODEC_ID_RAWVIDEO;
  track->codecpar->format = AV_PIX_FMT_BAYER_RGGB8;
  track->codecpar->codec_tag = avcodec_pix_fmt_to_codec_tag(AV_PIX_FMT_BAYER_RGGB8);
  track->codecpar->width = track->codecpar->height = 16;
  track->time_base = {1, 30};
  REQUIRE(avio_open(&video->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0);
  REQUIRE(avformat_write_header(video, nullptr) >= 0);
  std::vector<std::uint8_t> codes(std::size_t{16} * 16, 128);
  const libav::Packet packet(av_packet_alloc());
  packet->data = codes.data(), packet->size = static_cast<int>(codes.size());
  packet->pts = packet->dts = 0, packet->flags |= AV_PKT_FLAG_KEY;
  REQUIRE(av_write_frame(video, packet.get()) >= 0);
  REQUIRE(av_write_trailer(video) >= 0);
  avio_closep(&video->pb);
  avformat_free_context(video);
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

TEST_CASE("interlaced video is refused with a filter that neither doubles its frames nor mixes exposures") {
  const std::string path = sample::scratch_folder("footage_interlaced") + "/x.y4m";
  std::ofstream(path, std::ios::binary) << "YUV4MPEG2 W16 H16 F30:1 It A1:1 Cmono\nFRAME\n"
                                        << std::string(std::size_t{16} * 16, '\x80');
  const ReadFootage refused = read_footage({path});
  REQUIRE(refused.error);
  CHECK(refused.error->code == ErrorCode::Unsupported);
  CHECK_THAT(refused.error->message,
             Contains("'" + path + "' is interlaced") && Contains("ffmpeg -vf estdif=mode=frame"));
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

TEST_CASE("video of a mosaic is refused with the way on which its codes stay as they are") {
  const std::string path = sample::scratch_folder("footage_mosaic") + "/x.nut";
  write_mosaic_video(path);
  const ReadFootage refused = read_footage({path});
  REQUIRE(refused.error);
  CHECK(refused.error->code == ErrorCode::Unsupported);
  CHECK_THAT(refused.error->message,
             Contains("bayer_rggb8, a mosaic") && Contains("grey PNG pictures, with a clip.json"));
}

TEST_CASE("a JPEG is turned upright by the orientation of its EXIF, with its sides and its lens") {
  const std::string path = sample::scratch_folder("footage_oriented_jpeg") + "/a.jpg";
  test::Exif exif;
  exif.focal_35mm_mm = 26;
  for (std::uint16_t orientation = 1; orientation <= 8; ++orientation) {
    CAPTURE(orientation);
    exif.orientation = orientation;
    test::write_jpeg(path, stored_as(orientation, patches(0)), exif);
    const ReadFootage still = read_footage({path});
    REQUIRE_FALSE(still.error);
    check_upright(still, 4);  // codes of 255, as the codec leaves them
    REQUIRE(still.camera.intrinsics);
    CHECK(still.camera.intrinsics->cx_px == 48);
    CHECK(still.camera.intrinsics->cy_px == 32);
  }
}

TEST_CASE(
    "PNG and TIFF pictures are turned upright by the orientation that they state, and keep every code") {
  const std::string folder = sample::scratch_folder("footage_oriented_png");
  for (std::uint16_t orientation = 1; orientation <= 8; ++orientation) {
    CAPTURE(orientation);
    const Image<std::uint16_t> stored = stored_as(orientation, patches(0));
    const std::string png = png_file(folder + "/a.png", stored);
    add_exif_to_png(png, orientation);
    for (const ReadFootage& still :
         {read_footage({png}), read_footage({tiff_file(folder + "/a.tif", stored, orientation)})}) {
      REQUIRE_FALSE(still.error);
      check_sides(still);
      CHECK(sample::same(still.frames[0].codes, patches(0)));
    }
  }
}

TEST_CASE(
    "a video is turned upright by its display matrix, and no other angle than of 90 degrees is applied") {
  const std::string path = sample::scratch_folder("footage_oriented_video") + "/x.mp4";
  constexpr std::int32_t kOne = 1 << 16;
  const std::pair<std::uint16_t, DisplayMatrix> turns[] = {
      {1, {kOne, 0, 0, kOne}}, {2, {-kOne, 0, 0, kOne}}, {3, {-kOne, 0, 0, -kOne}}, {4, {kOne, 0, 0, -kOne}},
      {5, {0, kOne, kOne, 0}}, {6, {0, kOne, -kOne, 0}}, {7, {0, -kOne, -kOne, 0}}, {8, {0, -kOne, kOne, 0}}};
  for (const auto& [orientation, matrix] : turns) {
    CAPTURE(orientation);
    std::vector<Image<std::uint16_t>> stored;
    for (const int picture : {0, 1}) stored.push_back(stored_as(orientation, patches(picture)));
    REQUIRE(test::write_video(path, VideoCodec::H264, stored).ok());
    set_display_matrix(path, matrix);
    const ReadFootage video = read_footage({path});
    REQUIRE_FALSE(video.error);
    check_upright(video, 5);
    const auto footage = open_footage(posix_storage(), {path}, 0);
    REQUIRE(footage.value()->orientations().size() == 1);
    CHECK(footage.value()->orientations()[0].orientation == orientation_of_exif(orientation));
    CHECK_FALSE(footage.value()->oblique());
  }
  set_display_matrix(path, {56756, 32768, -32768, 56756});  // by 30 degrees
  const auto footage = open_footage(posix_storage(), {path}, 0);
  REQUIRE(footage.ok());
  CHECK(footage.value()->oblique());
  CHECK(footage.value()->camera().width == 64);  // as the last one of the turns is stored
}

TEST_CASE("pictures whose sizes differ once they are upright make no clip, and the error names the file") {
  const std::string folder = sample::scratch_folder("footage_orientations");
  test::Exif exif;
  test::write_jpeg(folder + "/a.jpg", patches(0), exif);
  exif.orientation = 3;
  test::write_jpeg(folder + "/b.jpg", patches(0), exif);
  exif.orientation = 6;
  test::write_jpeg(folder + "/c.jpg", patches(0), exif);
  const ReadFootage alike = read_footage({folder + "/a.jpg", folder + "/b.jpg"});
  CHECK_FALSE(alike.error);
  const ReadFootage other = read_footage({folder + "/a.jpg", folder + "/b.jpg", folder + "/c.jpg"});
  CHECK_THAT(refusal(other, ErrorCode::SizeChanged),
             Contains("/c.jpg' has 64x96 pixels") && Contains("turned by 90 degrees as it states") &&
                 Contains("the clip began with 96x64") && Contains("of one orientation"));
}
