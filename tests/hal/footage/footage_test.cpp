#include "hal/footage/footage.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <tuple>

#include "hal/recording/png_image.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/footage_files.h"
#include "tests/support/tiff_directory.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

// Patches of 16 pixels, every one another colour; pictures differ in their codes.
Image<std::uint16_t> patches(int picture, int rows = 64, int cols = 96) {
  Image<std::uint16_t> rgb(3, rows, cols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        rgb.at(c, y, x) =
            static_cast<std::uint16_t>((37 * (y / 16) + 61 * (x / 16) + 90 * c + 20 * picture) % 256);
  return rgb;
}

std::vector<Image<std::uint16_t>> pictures(int count) {
  std::vector<Image<std::uint16_t>> all;
  for (int i = 0; i < count; ++i) all.push_back(patches(i));
  return all;
}

struct Read {
  CameraFacts camera;
  std::string about;
  std::vector<RawFrame> frames;
  std::vector<FootageLosses> losses;
  std::optional<Error> error;
};

Read read(std::vector<std::string> files, double framerate_hz = 0) {
  Read all;
  auto footage = open_footage(posix_storage(), std::move(files), framerate_hz);
  if (!footage) return all.error = footage.error(), std::move(all);
  all.camera = footage.value()->camera(), all.about = footage.value()->about();
  for (;;) {
    RawFrame frame;
    const auto more = footage.value()->next(frame);
    if (!more) return all.error = more.error(), std::move(all);
    if (!more.value()) return all.losses = footage.value()->losses(), std::move(all);
    all.frames.push_back(std::move(frame));
  }
}

// The largest difference in the middles of the patches, codes of 255.
double difference(const RawFrame& frame, int bits, const Image<std::uint16_t>& rgb) {
  const double scale = 255.0 / ((1 << bits) - 1);
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 8; y < rgb.rows(); y += 16)
      for (int x = 8; x < rgb.cols(); x += 16)
        largest = std::max(largest, std::abs(frame.codes.at(c, y, x) * scale - rgb.at(c, y, x)));
  return largest;
}

std::string png(const std::string& path, const Image<std::uint16_t>& rgb, int bits = 8) {
  REQUIRE(write_png(posix_storage(), path, {bits, rgb.clone()}).ok());
  return path;
}

// Of 16 bits, in one strip, with a unit of resolution as most programs write it.
std::string tiff(const std::string& path, const Image<std::uint16_t>& rgb) {
  const auto rows = static_cast<std::uint32_t>(rgb.rows()), cols = static_cast<std::uint32_t>(rgb.cols());
  const auto directory = [&](std::uint32_t strip_at) {
    namespace tag = test::tiff_tag;
    test::TiffDirectory tags;
    tags.longs(tag::kImageWidth, {cols});
    tags.longs(tag::kImageLength, {rows});
    tags.shorts(tag::kBitsPerSample, {16, 16, 16});
    tags.shorts(tag::kCompression, {1});
    tags.shorts(tag::kPhotometricInterpretation, {2});
    tags.longs(tag::kStripOffsets, {strip_at});
    tags.shorts(tag::kSamplesPerPixel, {3});
    tags.longs(tag::kRowsPerStrip, {rows});
    tags.longs(tag::kStripByteCounts, {rows * cols * 6});
    tags.shorts(tag::kResolutionUnit, {2});
    return tags.at(8);
  };
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(static_cast<std::uint32_t>(8 + directory(0).size())))
    bytes.push_back(byte);
  for (int y = 0; y < rgb.rows(); ++y)
    for (int x = 0; x < rgb.cols(); ++x)
      for (int c = 0; c < 3; ++c) test::TiffDirectory::put(bytes, rgb.at(c, y, x), 2);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return path;
}

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
  const Read read_back = read({path});
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
    const Read untagged = read({path});
    INFO(width << "x" << height);
    REQUIRE(untagged.frames.size() == 1);
    CHECK(untagged.frames.front().codes.at(0, 1, 1) / 1023.0 * 255 == Approx(red).margin(0.2));
  }
}

TEST_CASE("HEVC of ten bits keeps its depth, and a variable frame rate its times") {
  const std::string path = sample::scratch_folder("footage_hevc") + "/x.mkv";
  const std::vector<double> times{0, 0.033, 0.08, 0.1, 0.25};
  REQUIRE(test::write_video(path, VideoCodec::Hevc, pictures(5), times).ok());
  const Read read_back = read({path});
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
    const Read colour = read({png(folder + "/a.png", rgb, bits), png(folder + "/b.png", rgb, bits)}, 25);
    REQUIRE_FALSE(colour.error);
    CHECK(colour.camera.bits == bits);
    CHECK(colour.camera.framerate_hz == Approx(25));
    REQUIRE(colour.frames.size() == 2);
    CHECK(sample::same(colour.frames[0].codes, rgb));
    CHECK(colour.frames[1].facts.timestamp.seconds() == Approx(0.04));
    Image<std::uint16_t> grey(1, 33, 47);
    std::copy_n(rgb.plane(0), rgb.plane_size(), grey.plane(0));
    const Read mono = read({png(folder + "/c.png", grey, bits)});
    REQUIRE_FALSE(mono.error);
    CHECK(mono.camera.layout == PixelLayout::Mono);
    CHECK(sample::same(mono.frames[0].codes, grey));
  }
}

TEST_CASE("a PNG that is stored in the order of Adam7 is no interlaced video") {
  const std::string path = sample::scratch_folder("footage_adam7") + "/a.png";
  write_interlaced_png(path, patches(1, 33, 47));
  const Read read_back = read({path});
  REQUIRE_FALSE(read_back.error);
  REQUIRE(read_back.frames.size() == 1);
  CHECK(sample::same(read_back.frames[0].codes, patches(1, 33, 47)));
}

TEST_CASE("TIFF pictures keep every code, whatever else their tags say") {
  const std::string path = sample::scratch_folder("footage_tiff") + "/a.tif";
  Image<std::uint16_t> rgb = patches(2, 33, 47);
  for (auto& code : rgb.samples()) code = static_cast<std::uint16_t>(code * 257 - (code > 0 ? 1 : 0));
  const Read read_back = read({tiff(path, rgb)});
  REQUIRE_FALSE(read_back.error);
  CHECK(read_back.camera.bits == 16);
  REQUIRE(read_back.frames.size() == 1);
  CHECK(sample::same(read_back.frames[0].codes, rgb));
}

TEST_CASE("a TIFF of floating point is refused for its kind, not only called damaged") {
  const std::string path = sample::scratch_folder("footage_float_tiff") + "/a.tif";
  std::string bytes = read_whole(posix_storage(), tiff(path, patches(0))).value();
  const std::string bits("\x10\0\x10\0\x10\0", 6);
  REQUIRE(bytes.find(bits) != std::string::npos);
  bytes.replace(bytes.find(bits), bits.size(), std::string("\x20\0\x20\0\x20\0", 6));
  std::ofstream(path, std::ios::binary) << bytes;
  const Read read_back = read({path});
  REQUIRE(read_back.error);
  CHECK_THAT(read_back.error->message, Contains("of a kind that FFmpeg does not know") ||  // before FFmpeg 6
                                           Contains("has pixels of the format rgbf32"));
}

TEST_CASE("JPEG pictures say their exposure in EXIF: time, sensitivity, aperture") {
  const std::string folder = sample::scratch_folder("footage_jpeg");
  test::write_jpeg(folder + "/a.jpg", patches(0), test::Exif{1, 1000, 100, 28});
  test::write_jpeg(folder + "/b.jpg", patches(1), test::Exif{10, 60, 400, 56});
  test::write_jpeg(folder + "/c.jpg", patches(2), std::nullopt);
  const Read bracket = read({folder + "/a.jpg", folder + "/b.jpg", folder + "/c.jpg"});
  REQUIRE_FALSE(bracket.error);
  REQUIRE(bracket.frames.size() == 3);
  CHECK(bracket.frames[0].facts.exposure_source == ExposureSource::Embedded);
  CHECK(bracket.frames[0].facts.exposure_s == Approx(0.001));
  CHECK(bracket.frames[0].facts.analogue_gain == Approx(1));
  CHECK(bracket.frames[1].facts.exposure_s == Approx(1.0 / 6));
  CHECK(bracket.frames[1].facts.analogue_gain == Approx(4));
  CHECK(bracket.frames[0].facts.digital_gain / bracket.frames[1].facts.digital_gain ==
        Approx(4));  // two stops
  CHECK(bracket.frames[2].facts.exposure_source == ExposureSource::Unknown);
  CHECK(difference(bracket.frames[0], bracket.camera.bits, patches(0)) < 2.5);
  CHECK(bracket.camera.framerate_hz == Approx(30));  // stills do not say it
}

TEST_CASE("an exposure time of numbers from 2^31 on is no negative one") {
  const std::string path = sample::scratch_folder("footage_large_rational") + "/a.jpg";
  const std::pair<test::Exif, double> times[] = {{{4'000'000'000, 1'000'000'000}, 4},
                                                 {{10'000'000, 2'500'000'000}, 0.004},
                                                 {{2'147'483'648, 4'294'967'295}, 0.5}};
  for (const auto& [exif, time_s] : times) {
    CAPTURE(exif.time_numerator, exif.time_denominator);
    test::write_jpeg(path, patches(0), exif);
    const Read still = read({path});
    REQUIRE_FALSE(still.error);
    REQUIRE(still.frames.size() == 1);
    CHECK(still.frames[0].facts.exposure_source == ExposureSource::Embedded);
    CHECK(still.frames[0].facts.exposure_s == Approx(time_s));
  }
}

TEST_CASE("of a JPEG with two EXIF segments the first one counts, as in other readers") {
  const std::string path = sample::scratch_folder("footage_two_exif") + "/a.jpg";
  test::write_jpeg(path, patches(0), test::Exif{1, 250, 400, 56});
  const std::vector<std::uint8_t> first = test::exif_segment({1, 1000, 100, 28});
  const std::size_t length = first.size() + 2;
  const std::string mark{'\xff', '\xe1', static_cast<char>(length >> 8), static_cast<char>(length & 255)};
  std::string bytes = test::text_of(path);
  bytes.insert(2, mark + std::string(first.begin(), first.end()));  // behind the start of the image
  std::ofstream(path, std::ios::binary) << bytes;
  const Read still = read({path});
  REQUIRE_FALSE(still.error);
  REQUIRE(still.frames.size() == 1);
  CHECK(still.frames[0].facts.exposure_s == Approx(0.001));
  CHECK(still.frames[0].facts.analogue_gain == Approx(1));
  CHECK(difference(still.frames[0], still.camera.bits, patches(0)) < 2.5);
}

TEST_CASE("stills of two models of cameras are no clip, and both are named") {
  const std::string folder = sample::scratch_folder("footage_models");
  const std::vector<std::string> models{"", "EOS R5 ", "EOS R5", "X-T4"};
  std::vector<std::string> files;
  for (std::size_t i = 0; i < models.size(); ++i) {
    files.push_back(fmt::format("{}/{}.jpg", folder, i));
    test::Exif exif;
    exif.model = models[i];
    test::write_jpeg(files.back(), patches(static_cast<int>(i)), exif);
  }
  const Read mixed = read(files);
  REQUIRE(mixed.error);
  CHECK(mixed.error->code == ErrorCode::Invalid);
  CHECK(mixed.frames.size() == 3);
  CHECK_THAT(mixed.error->message, Contains("3.jpg' is of a X-T4") && Contains("1.jpg' of a EOS R5,"));
  files.pop_back();
  CHECK_FALSE(read(files).error);
}

TEST_CASE("a sensitivity beyond 65535 is the one that EXIF states beside it") {
  const std::string folder = sample::scratch_folder("footage_iso");
  test::Exif exif{1, 1000, 65535, 28};
  exif.exposure_index = 204800;
  test::write_jpeg(folder + "/a.jpg", patches(0), exif);
  exif.iso = 51200;  // what stands beside it does not count
  test::write_jpeg(folder + "/b.jpg", patches(1), exif);
  const Read bracket = read({folder + "/a.jpg", folder + "/b.jpg"});
  REQUIRE_FALSE(bracket.error);
  REQUIRE(bracket.frames.size() == 2);
  CHECK(bracket.frames[0].facts.analogue_gain == Approx(2048));
  CHECK(bracket.frames[1].facts.analogue_gain == Approx(512));
}

TEST_CASE("an exposure that EXIF states in APEX alone is a time and an f-number") {
  const std::string folder = sample::scratch_folder("footage_apex");
  const std::pair<int, double> times[] = {{80, 1. / 256}, {-10, 2}};  // tenths of APEX, seconds
  for (const auto& [apex, time_s] : times) {
    test::Exif exif;
    exif.time_apex = apex, exif.aperture_apex = 40;  // f/4
    test::write_jpeg(folder + "/a.jpg", patches(0), exif);
    const Read still = read({folder + "/a.jpg"});
    REQUIRE_FALSE(still.error);
    REQUIRE(still.frames.size() == 1);
    CHECK(still.frames[0].facts.exposure_source == ExposureSource::Embedded);
    CHECK(still.frames[0].facts.exposure_s == Approx(time_s));
    CHECK(still.frames[0].facts.digital_gain == Approx(1. / 16));
  }
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

TEST_CASE("a sensitivity that EXIF states as recommended exposure index alone counts") {
  const std::string folder = sample::scratch_folder("footage_index");
  test::Exif exif{1, 1000, 0, 28};
  exif.exposure_index = 400;
  test::write_jpeg(folder + "/a.jpg", patches(0), exif);
  const auto footage = open_footage(posix_storage(), {folder + "/a.jpg"}, 0);
  REQUIRE(footage.ok());
  RawFrame frame;
  REQUIRE(footage.value()->next(frame).value());
  CHECK(frame.facts.analogue_gain == Approx(4));
  CHECK(footage.value()->factors().iso);
}

TEST_CASE("what lies behind the picture of a still, a preview or a gain map, is no frame") {
  const std::string folder = sample::scratch_folder("footage_second_picture");
  test::write_jpeg(folder + "/preview.jpg", patches(7, 32, 48), std::nullopt);
  test::write_jpeg(folder + "/gain.jpg", patches(8), std::nullopt);
  const std::string preview = test::text_of(folder + "/preview.jpg"),
                    gain = test::text_of(folder + "/gain.jpg");
  std::vector<std::string> files;
  for (const std::string& behind : {preview, gain, gain + preview, gain.substr(0, gain.size() / 2)}) {
    const auto number = static_cast<int>(files.size());
    const std::string& path = files.emplace_back(fmt::format("{}/{}.jpg", folder, number));
    test::write_jpeg(path, patches(number), test::Exif{1, 1000, 100, 28});
    std::ofstream(path, std::ios::binary | std::ios::app) << behind;
  }
  const Read bracket = read(files);
  INFO((bracket.error ? bracket.error->message : ""));
  REQUIRE_FALSE(bracket.error);
  CHECK(bracket.losses.empty());
  CHECK(bracket.camera.framerate_hz == Approx(30));
  REQUIRE(bracket.frames.size() == files.size());
  for (std::size_t i = 0; i < files.size(); ++i)
    CHECK(difference(bracket.frames[i], bracket.camera.bits, patches(static_cast<int>(i))) < 2.5);
  // a damaged picture is not replaced by its preview
  test::write_jpeg(folder + "/large.jpg", patches(9, 480, 640), std::nullopt);
  const std::string damaged = folder + "/damaged.jpg", whole = test::text_of(folder + "/large.jpg");
  std::ofstream(damaged, std::ios::binary) << whole.substr(0, whole.size() / 2) << "\xff\xd9" << preview;
  const Read refused = read({damaged});
  REQUIRE(refused.error);
  CHECK(refused.error->code == ErrorCode::Corrupt);
}

TEST_CASE("files in a folder come in the order of their numbers") {
  const std::string folder = sample::scratch_folder("footage_order");
  for (const char* name : {"IMG_10.JPG", "IMG_9.jpg", "IMG_09.jpg", "IMG_009.jpg", "img_2.png",
                           "IMG_0011.jpg", "notes.txt", "clip.mov", "._IMG_9.jpg"})
    std::ofstream(folder + "/" + name) << "x";
  const auto files = footage_in(folder);
  REQUIRE(files.ok());
  std::vector<std::string> expected;
  for (const char* name :
       {"IMG_009.jpg", "IMG_09.jpg", "IMG_9.jpg", "IMG_10.JPG", "IMG_0011.jpg", "clip.mov", "img_2.png"})
    expected.push_back(folder + "/" + name);
  CHECK(files.value() == expected);
  CHECK(other_pictures_in(folder).empty());
  for (const char* name : {"IMG_12.HEIC", "IMG_3.webp", "._IMG_4.heic"})
    std::ofstream(folder + "/" + name) << "x";
  CHECK(footage_in(folder).value() == expected);
  CHECK(other_pictures_in(folder) ==
        std::vector<std::string>{folder + "/IMG_3.webp", folder + "/IMG_12.HEIC"});
  const std::string empty = sample::scratch_folder("footage_empty");
  CHECK(sample::error_of(footage_in(empty)).code == ErrorCode::NotFound);
  std::ofstream(empty + "/x.bmp") << "x";  // such are read where they are named
  CHECK_THAT(sample::error_of(footage_in(empty)).message, Contains(empty) && Contains("name files of other"));
}

TEST_CASE("a folder whose folders hold the footage, as that of a card, leads to the first of these") {
  const std::string card = sample::scratch_folder("footage_card");
  for (const char* folder : {"/.thumbs", "/99MISC", "/100MEDIA", "/101MEDIA"})
    std::filesystem::create_directory(card + folder);
  for (const char* file : {"/.thumbs/1.jpg", "/99MISC/notes.txt", "/100MEDIA/1.jpg", "/101MEDIA/2.jpg"})
    std::ofstream(card + file) << "x";
  const Error refused = sample::error_of(footage_in(card));
  CHECK(refused.code == ErrorCode::NotFound);
  CHECK_THAT(refused.message, Contains("; such are in '" + card + "/100MEDIA'"));
}

TEST_CASE("neighbouring numbers are those of files whose names are alike else") {
  CHECK(is_next_number("card/IMG_0009.JPG", "card/IMG_0010.JPG"));
  CHECK(is_next_number("IMG_9.CR2", "IMG_10.CR2"));
  for (const auto& [file, next] : {std::pair("IMG_0003.JPG", "IMG_9998.JPG"),
                                   {"IMG_0010.JPG", "IMG_0009.JPG"},
                                   {"IMG_0009.JPG", "DSC_0010.JPG"},
                                   {"IMG_0009.JPG", "IMG_0010_small.JPG"},
                                   {"100/IMG_0009.JPG", "101/IMG_0010.JPG"},
                                   {"take1/x.JPG", "take2/x.JPG"},
                                   {"a.mp3", "a.mp4"},
                                   {"IMG_99999999999999999999.JPG", "IMG_100000000000000000000.JPG"}}) {
    CAPTURE(file, next);
    CHECK_FALSE(is_next_number(file, next));
  }
}

TEST_CASE("a number is earlier than another one where the names are alike else, and in one folder") {
  CHECK(is_earlier_number("card/IMG_10.JPG", "card/IMG_2.JPG"));
  CHECK(is_earlier_number("1/IMG_0010.JPG", "1/IMG_0009.JPG"));
  for (const auto& [file, next] : {std::pair("IMG_2.JPG", "IMG_10.JPG"),
                                   {"IMG_2.JPG", "IMG_2.JPG"},
                                   {"IMG_10.JPG", "DSC_2.JPG"},
                                   {"2/IMG_10.JPG", "1/IMG_2.JPG"},
                                   {"take2/x.JPG", "take1/x.JPG"}}) {
    CAPTURE(file, next);
    CHECK_FALSE(is_earlier_number(file, next));
  }
}

TEST_CASE("links in a folder are footage where their files are there, and found where they are not") {
  const std::string folder = sample::scratch_folder("footage_links"),
                    card = sample::scratch_folder("footage_links_card");
  std::ofstream(card + "/1.jpg") << "x";
  std::filesystem::create_symlink(card + "/1.jpg", folder + "/IMG_1.jpg");
  for (const char* name : {"IMG_10.jpg", "IMG_2.jpg", "IMG_3.heic", "clip.mov", "notes.txt", "._IMG_4.jpg"})
    std::filesystem::create_symlink(card + "/gone", folder + "/" + name);
  std::filesystem::create_symlink("IMG_5.png", folder + "/IMG_5.png");  // to itself
  CHECK(footage_in(folder).value() == std::vector<std::string>{folder + "/IMG_1.jpg"});
  CHECK(other_pictures_in(folder).empty());
  std::vector<std::string> broken;
  for (const char* name : {"IMG_2.jpg", "IMG_3.heic", "IMG_5.png", "IMG_10.jpg", "clip.mov"})
    broken.push_back(folder + "/" + name);
  CHECK(broken_links_in(folder) == broken);
}

TEST_CASE("what is no footage is an error that names the file") {
  const std::string folder = sample::scratch_folder("footage_wrong");
  const std::string text = folder + "/x.mp4";
  std::ofstream(text) << "this is no video, whatever it is called\n";
  const Read not_video = read({text});
  REQUIRE(not_video.error);
  CHECK(not_video.error->code == ErrorCode::NotRecording);
  CHECK_THAT(not_video.error->message, Contains(text));
  CHECK(read({folder + "/missing.mp4"}).error->code == ErrorCode::NotFound);
  for (const char* name : {"/empty.jpg", "/empty.mp4", "/empty.dng"}) {
    std::ofstream(folder + name).flush();
    const Read empty = read({folder + name});
    REQUIRE(empty.error);
    CHECK(empty.error->code == ErrorCode::NotRecording);
    CHECK_THAT(empty.error->message, Contains(fmt::format("{}' is empty", name)));
  }

  const Read sizes = read({png(folder + "/a.png", patches(0)), png(folder + "/b.png", patches(0, 32, 96))});
  REQUIRE(sizes.error);
  CHECK(sizes.error->code == ErrorCode::SizeChanged);
  CHECK_THAT(sizes.error->message,
             Contains("b.png") && Contains("96x32") && Contains("of one kind and size"));
}

TEST_CASE("pictures that no recording can hold are refused at once, and named") {
  const std::string folder = sample::scratch_folder("footage_sides");
  for (const auto& [rows, cols] : {std::pair{1, 64}, std::pair{64, 1}, std::pair{2, 16385}}) {
    const std::string path = png(fmt::format("{}/{}x{}.png", folder, cols, rows), patches(0, rows, cols));
    const Read refused = read({path});
    REQUIRE(refused.error);
    CHECK(refused.error->code == ErrorCode::Unsupported);
    CHECK_THAT(refused.error->message,
               Contains(path) && Contains(fmt::format("has {}x{} pixels", cols, rows)));
  }
  CHECK_FALSE(read({png(folder + "/wide.png", patches(0, 2, 16384))}).error);
}

TEST_CASE("a name is no pattern, and a playlist opens nothing") {
  const std::string folder = sample::scratch_folder("footage_names");
  test::write_jpeg(folder + "/a%02d.jpg", patches(0), std::nullopt);
  test::write_jpeg(folder + "/a01.jpg", patches(1), std::nullopt);
  const Read named = read({folder + "/a%02d.jpg"});
  REQUIRE_FALSE(named.error);
  REQUIRE(named.frames.size() == 1);
  CHECK(difference(named.frames[0], named.camera.bits, patches(0)) < 2.5);

  REQUIRE(test::write_video(folder + "/x.mkv", VideoCodec::H264, pictures(3)).ok());
  for (const char* list : {"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nx.mkv\n#EXT-X-ENDLIST\n",
                           "ffconcat version 1.0\nfile x.mkv\n"}) {
    std::ofstream(folder + "/list.txt") << list;
    const Read playlist = read({folder + "/list.txt"});
    REQUIRE(playlist.error);
    CHECK(playlist.error->code == ErrorCode::NotRecording);
  }
}

TEST_CASE("a video that was cut comes up to its cut") {
  const std::string path = sample::scratch_folder("footage_cut") + "/x.mkv";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(90)).ok());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) * 3 / 4);
  const Read read_back = read({path});
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
  const Read cut = read({path});
  REQUIRE(cut.error);
  CHECK(cut.error->code == ErrorCode::NotRecording);
  CHECK_THAT(cut.error->message, Contains(path) && Contains("one that was cut has lost its index"));
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
    const Read cut = read({path});
    REQUIRE(cut.error);
    CHECK((cut.error->code == ErrorCode::Truncated || cut.error->code == ErrorCode::NotRecording));
    CHECK_THAT(cut.error->message, Contains("is an MP4 or MOV that") && Contains("index"));
  }
}

TEST_CASE("a HEIC picture that FFmpeg cannot read is called one, and not a video that was cut") {
  const std::string path = sample::scratch_folder("footage_heic") + "/IMG_1.HEIC";
  const std::string type("\0\0\0\30ftypheic\0\0\0\0mif1heic", 24), samples("\0\1\0\0mdat", 8);
  std::ofstream(path, std::ios::binary) << type << samples << std::string(1000, '\0');
  const Read picture = read({path});
  REQUIRE(picture.error);
  CHECK(picture.error->code == ErrorCode::NotRecording);
  CHECK_THAT(picture.error->message, Contains(path) && Contains("HEIC") && !Contains("cut"));
}

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

}  // namespace

TEST_CASE("what a cut AVI lacks is counted by the number of frames that its head states") {
  const std::string path = sample::scratch_folder("footage_cut_avi") + "/x.avi";
  write_avi(path, pictures(24));
  const Read whole = read({path});
  CHECK(whole.losses.empty());
  CHECK(whole.frames.size() == 24);
  const auto size = std::filesystem::file_size(path);
  for (const double share : {0.9, 0.6, 0.3}) {
    CAPTURE(share);
    std::filesystem::resize_file(path, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
    const Read cut = read({path});
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
  const Read whole = read({path});
  CHECK(whole.losses.empty());
  CHECK(whole.frames.size() == kFrames);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1000);
  const Read cut = read({path});
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
    const Read cut = read({path});
    REQUIRE(cut.error);
    CHECK(cut.error->code == ErrorCode::Truncated);
    CHECK_THAT(cut.error->message, Contains("x.y4m' ends before the end of its first frame"));
  }
  std::filesystem::resize_file(path, head.size());
  const Read none = read({path});
  REQUIRE(none.error);
  CHECK(none.error->code == ErrorCode::NotRecording);
  CHECK_THAT(none.error->message, Contains("holds no pictures"));
}

TEST_CASE("a Matroska video that ends inside its first frame is called cut") {
  const std::string path = sample::scratch_folder("footage_cut_first_mkv") + "/x.mkv";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(3)).ok());
  const std::size_t cluster = test::text_of(path).find("\x1f\x43\xb6\x75");
  REQUIRE(cluster != std::string::npos);
  std::filesystem::resize_file(path, cluster + 40);
  const Read cut = read({path});
  REQUIRE(cut.error);
  CHECK(cut.error->code == ErrorCode::Truncated);
  CHECK_THAT(cut.error->message, Contains("x.mkv' ends before the end of its first frame"));
}

TEST_CASE("what a cut video lacks is counted, and a whole one lacks nothing") {
  const std::string path = sample::scratch_folder("footage_cut_mp4") + "/x.mp4";
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(30)).ok());
  CHECK(read({path}).losses.empty());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const Read read_back = read({path, path});
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

TEST_CASE("a video whose file states no frame rate is no still") {
  const std::string folder = sample::scratch_folder("footage_no_rate");
  REQUIRE(test::write_video(folder + "/x.mkv", VideoCodec::H264, pictures(2)).ok());
  REQUIRE(test::remux(folder + "/x.mkv", folder + "/x.nut", "nut").ok());  // from two frames none is found
  auto footage = open_footage(posix_storage(), {folder + "/x.nut"}, 0);
  REQUIRE(footage.ok());
  CHECK_FALSE(footage.value()->still());
  CHECK(footage.value()->timed());
  png(folder + "/x.png", patches(0));
  footage = open_footage(posix_storage(), {folder + "/x.png"}, 0);
  REQUIRE(footage.ok());
  CHECK(footage.value()->still());
}

TEST_CASE("a duration that was copied from the file before is not what a whole video lacks") {
  const std::string folder = sample::scratch_folder("footage_stale_duration");
  REQUIRE(test::write_video(folder + "/x.mkv", VideoCodec::H264, pictures(10)).ok());
  REQUIRE(test::remux(folder + "/x.mkv", folder + "/x.nut", "nut", "00:01:00.000000000").ok());
  const Read read_back = read({folder + "/x.nut"});
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
  const Read read_back = read({folder + "/a.mkv", folder + "/b.mkv"});
  REQUIRE(read_back.error);
  CHECK(read_back.error->code == ErrorCode::Corrupt);
  CHECK_THAT(read_back.error->message, Contains("/b.mkv', would come"));
}

namespace {

// A video of 20 pictures, a tenth of its bytes zeros.
void write_damaged(const std::string& path) {
  REQUIRE(test::write_video(path, VideoCodec::H264, pictures(20)).ok());
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path));
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const std::string zeros(static_cast<std::size_t>(size / 10), '\0');
  file.seekp(size / 2).write(zeros.data(), static_cast<std::streamsize>(zeros.size()));
}

}  // namespace

TEST_CASE("damaged frames of a video are left out and counted, and the others keep their times") {
  const std::string path = sample::scratch_folder("footage_damaged") + "/x.mp4";
  write_damaged(path);
  const Read read_back = read({path});
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
    for (const RawFrame& frame : read({path}).frames) times_s.push_back(frame.facts.timestamp.seconds());
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
  png(folder + "/c.png", patches(0)), png(folder + "/d.png", patches(1));
  tiff(folder + "/e.tif", patches(0)), tiff(folder + "/f.tif", patches(1));
  for (const auto& [whole, cut] :
       {std::pair{"/a.jpg", "/b.jpg"}, std::pair{"/c.png", "/d.png"}, std::pair{"/e.tif", "/f.tif"}}) {
    const std::string damaged = folder + cut;
    std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) * 2 / 3);
    for (const auto& files : {std::vector{folder + whole, damaged}, std::vector{damaged, folder + whole}}) {
      const Read read_back = read(files);
      REQUIRE(read_back.error);
      CHECK(read_back.error->code == ErrorCode::Corrupt);
      CHECK_THAT(read_back.error->message, Contains(damaged) && Contains("damaged or cut"));
    }
  }
}
