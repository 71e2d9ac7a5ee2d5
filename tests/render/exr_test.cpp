#include "render/exr.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "tests/contracts/expect.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

constexpr int kRows = 37, kCols = 53;  // no multiple of a block of scan lines

Image<float> ramp(float from, float to) {
  Image<float> image(1, kRows, kCols);
  for (std::size_t i = 0; i < image.size(); ++i)
    image.plane(0)[i] = from + (to - from) * static_cast<float>(i) / static_cast<float>(image.size() - 1);
  return image;
}

ExrPicture picture_of(const Image<float>& half, const Image<float>& full) {
  ExrPicture picture;
  picture.rows = kRows, picture.cols = kCols;
  picture.channels = {{"R", half.samples(), ExrSample::Half},
                      {"backward.u", full.samples(), ExrSample::Float}};
  return picture;
}

ExrImage round_trip(const ExrPicture& picture) {
  const auto bytes = encode_exr(picture);
  REQUIRE(bytes.ok());
  auto image = decode_exr(bytes.value(), "memory.exr");
  REQUIRE(image.ok());
  return std::move(image).value();
}

// Makes the file display the picture between the corners x0 y0 x1 y1, inclusively.
void show(const std::array<std::int32_t, 4>& corners, std::vector<std::byte>& file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  constexpr std::string_view kWindow("displayWindow\0box2i\0\x10\0\0\0", 24);
  const std::size_t window = text.find(kWindow);
  REQUIRE(window != std::string_view::npos);
  std::memcpy(file.data() + window + kWindow.size(), corners.data(), sizeof corners);
}

}  // namespace

TEST_CASE("an OpenEXR picture comes back: float exactly, half to its eleven bits") {
  const Image<float> half = ramp(0.01f, 900), full = ramp(-3e5f, 1e6f);
  for (const auto compression :
       {ExrCompression::None, ExrCompression::Rle, ExrCompression::Zip, ExrCompression::Piz}) {
    ExrPicture picture = picture_of(half, full);
    picture.compression = compression;
    const ExrImage image = round_trip(picture);
    REQUIRE(image.samples.rows() == kRows);
    REQUIRE(image.samples.cols() == kCols);
    REQUIRE(image.names == std::vector<std::string>{"R", "backward.u"});
    const float* read_half = image.samples.plane(*image.find("R"));
    const float* read_full = image.samples.plane(*image.find("backward.u"));
    for (std::size_t i = 0; i < half.size(); ++i) {
      REQUIRE(std::abs(read_half[i] - half.plane(0)[i]) <= half.plane(0)[i] / 2048);
      REQUIRE(read_full[i] == full.plane(0)[i]);
    }
    REQUIRE_FALSE(image.find("Z").has_value());
  }
}

TEST_CASE("the compression that was asked for is the one that the header names") {
  const Image<float> half = ramp(0, 1), full = ramp(0, 1);
  using namespace std::string_literals;
  // the attribute as the format lays it out: name, type, size, and the number of the method
  const auto attribute = [](char method) {
    return "compression\0compression\0\1\0\0\0"s + std::string(1, method);
  };
  for (const auto& [compression, method] : {std::pair{ExrCompression::None, '\0'},
                                            {ExrCompression::Rle, '\1'},
                                            {ExrCompression::Zip, '\3'},
                                            {ExrCompression::Piz, '\4'}}) {
    ExrPicture picture = picture_of(half, full);
    picture.compression = compression;
    const auto bytes = encode_exr(picture);
    REQUIRE(bytes.ok());
    const std::string text(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
    CHECK(text.find(attribute(method)) != std::string::npos);
  }
}

TEST_CASE("a file that takes the memory of a longer or a shorter one has the same bytes") {
  const Image<float> half = ramp(0.01f, 900), full = ramp(-3e5f, 1e6f);
  ExrPicture picture = picture_of(half, full);
  picture.compression = ExrCompression::None;
  const std::vector<std::byte> fresh = value_of(encode_exr(picture));
  for (const std::size_t before : {std::size_t{1}, fresh.size(), 3 * fresh.size()}) {
    std::vector<std::byte> room(before, std::byte{0x55});
    const std::byte* memory = room.data();
    const std::vector<std::byte> again = value_of(encode_exr(picture, std::move(room)));
    CHECK(again == fresh);
    if (before >= fresh.size()) CHECK(again.data() == memory);
  }
}

TEST_CASE("a value beyond half is clamped to 65504, and stays what it is as float") {
  Image<float> bright = ramp(1e5f, 1e9f), dark = ramp(-1e9f, -1e5f);
  const Image<float> full = bright.clone();
  ExrPicture picture = picture_of(bright, full);
  picture.channels.push_back({"B", dark.samples(), ExrSample::Half});
  const ExrImage image = round_trip(picture);
  for (std::size_t i = 0; i < bright.size(); ++i) {
    REQUIRE(image.samples.plane(*image.find("R"))[i] == 65504.0f);
    REQUIRE(image.samples.plane(*image.find("B"))[i] == -65504.0f);
    REQUIRE(image.samples.plane(*image.find("backward.u"))[i] == full.plane(0)[i]);
  }
}

TEST_CASE("a NaN or Inf handed to the encoder is a bug that ends the program") {
  for (const float poison :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Image<float> plane = ramp(0, 1);
    plane.at(0, 20, 30) = poison;
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(2);
      std::signal(SIGABRT, SIG_DFL);
      (void)encode_exr(picture_of(plane, plane));
      _exit(0);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    REQUIRE(WTERMSIG(status) == SIGABRT);
  }
}

TEST_CASE("the facts of a frame are readable back from its OpenEXR picture") {
  const Image<float> plane = ramp(0, 1);
  ExrPicture picture = picture_of(plane, plane);
  const double c = std::cos(std::numbers::pi / 5), s = std::sin(std::numbers::pi / 5);
  ExrAttributes& a = picture.attributes;
  a.exposure_s = 1.0 / 250;
  a.framerate_hz = 30000.0 / 1001;
  a.white_cd_m2 = 203;
  a.chromaticities = Chromaticities{};
  a.time_code = TimeCode{1, 2, 3, 29};
  a.owner = "the owner";
  a.comments = "E_ref 0.004 s";
  a.texts = {{"hdrcam.exposureVerdict", "proved"}, {"hdrcam.exposureSource", "reported"}};
  a.T_world_camera = PoseMatrix{c, 0, s, 1.5, 0, 1, 0, -0.25, -s, 0, c, 4};

  const ExrAttributes b = round_trip(picture).attributes;
  REQUIRE(*b.exposure_s == Approx(1.0 / 250));
  REQUIRE(*b.framerate_hz == 30000.0 / 1001);
  REQUIRE(*b.white_cd_m2 == Approx(203));
  REQUIRE(*b.chromaticities == Chromaticities{});
  REQUIRE(*b.time_code == TimeCode{1, 2, 3, 29});
  REQUIRE(b.owner == "the owner");
  REQUIRE(b.comments == "E_ref 0.004 s");
  REQUIRE(b.texts == a.texts);
  for (std::size_t i = 0; i < 12; ++i)
    REQUIRE((*b.T_world_camera)[i] == Approx((*a.T_world_camera)[i]).margin(1e-6));
}

TEST_CASE("worldToCamera takes a point to the axes of OpenEXR's camera: right, up, forward") {
  const Image<float> plane = ramp(0, 1);
  ExrPicture picture = picture_of(plane, plane);
  // turned to the right by a quarter: it looks along the world's x
  picture.attributes.T_world_camera = PoseMatrix{0, 0, 1, 10, 0, 1, 0, 20, -1, 0, 0, 30};
  const std::vector<std::byte> bytes = value_of(encode_exr(picture));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::string_view kName("worldToCamera\0m44f\0\x40\0\0\0", 23);
  const std::size_t found = text.find(kName);
  REQUIRE(found != std::string_view::npos);
  std::array<std::array<float, 4>, 4> m{};
  std::memcpy(m.data(), bytes.data() + found + kName.size(), sizeof m);
  const std::array<float, 4> p_world{15, 18, 29, 1};  // 5 ahead, 2 above, 1 to the right; y is down
  std::array<float, 4> p_camera{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k) p_camera[i] += p_world[k] * m[k][i];
  CHECK(p_camera == std::array<float, 4>{1, 2, 5, 1});
}

TEST_CASE("an OpenEXR picture states the nominal rate of a camera whose interval is rounded") {
  const Image<float> plane = ramp(0, 1);
  ExrPicture picture = picture_of(plane, plane);
  for (const auto& [interval_s, nominal_hz] : {std::pair(0.033333333, 30.0),
                                               {0.033333, 30.0},
                                               {0.033366667, 30000.0 / 1001},
                                               {0.016666667, 60.0},
                                               {2.0, 0.5}}) {
    picture.attributes.framerate_hz = 1 / interval_s;
    CHECK(*round_trip(picture).attributes.framerate_hz == nominal_hz);
  }
}

TEST_CASE("a picture without facts has none") {
  const Image<float> plane = ramp(0, 1);
  const ExrAttributes a = round_trip(picture_of(plane, plane)).attributes;
  REQUIRE_FALSE((a.exposure_s || a.framerate_hz || a.white_cd_m2 || a.chromaticities || a.time_code ||
                 a.T_world_camera));
  REQUIRE((a.owner.empty() && a.comments.empty()));
}

TEST_CASE("an OpenEXR file cut anywhere is an error, never a crash or a picture") {
  const Image<float> half = ramp(0, 5), full = ramp(-4, 4);
  for (const auto compression :
       {ExrCompression::None, ExrCompression::Rle, ExrCompression::Zip, ExrCompression::Piz}) {
    ExrPicture picture = picture_of(half, full);
    picture.compression = compression;
    const std::vector<std::byte> bytes = encode_exr(picture).value();
    for (std::size_t length = 0; length < bytes.size(); length += 13) {
      const auto image = decode_exr(std::span(bytes).first(length), "cut.exr");
      REQUIRE_FALSE(image.ok());
      REQUIRE((image.error().code == ErrorCode::Truncated || image.error().code == ErrorCode::Corrupt));
      REQUIRE(image.error().message.find("cut.exr") != std::string::npos);
    }
    const auto nearly = decode_exr(std::span(bytes).first(bytes.size() - 1), "cut.exr");
    REQUIRE_FALSE(nearly.ok());
    REQUIRE(nearly.error().code == ErrorCode::Truncated);
  }
}

TEST_CASE("an OpenEXR file with flipped bits is a picture or an error, never a crash") {
  const Image<float> half = ramp(0, 5), full = ramp(-4, 4);
  const std::vector<std::byte> whole = encode_exr(picture_of(half, full)).value();
  std::mt19937 random(5);
  int errors = 0;
  for (int i = 0; i < 400; ++i) {
    std::vector<std::byte> bytes = whole;
    // half of the flips in the header, where they hurt most
    const std::size_t reach = i % 2 == 0 ? std::min<std::size_t>(bytes.size(), 400) : bytes.size();
    bytes[random() % reach] ^= std::byte(1u << (random() % 8));
    errors += decode_exr(bytes, "flipped.exr").ok() ? 0 : 1;
  }
  REQUIRE(errors > 40);
}

TEST_CASE("a header that claims more than its file can hold costs no memory") {
  std::mt19937 random(5);
  Image<float> noise(1, 64, 64);
  for (float& value : noise.samples()) value = static_cast<float>(random() % 1000);
  ExrPicture picture;
  picture.rows = picture.cols = 64;
  picture.channels = {{"R", noise.samples(), ExrSample::Float}};
  picture.compression = ExrCompression::Zip;
  std::vector<std::byte> bytes = encode_exr(picture).value();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::string_view kWindow("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::size_t window = text.find(kWindow);
  REQUIRE(window != std::string_view::npos);
  const std::int32_t largest[2] = {65535, 1023};  // x, y: 64 Mi samples in some kilobytes
  std::memcpy(bytes.data() + window + kWindow.size() + 8, largest, sizeof largest);
  const auto image = decode_exr(bytes, "claim.exr");
  REQUIRE_FALSE(image.ok());
  CHECK(image.error().code == ErrorCode::Truncated);
  CHECK(image.error().message.find("too few for 1 channels of 65536x1024") != std::string::npos);
}

TEST_CASE("7680x4320 pixels with all layers of a frame are no claim too large") {
  const Image<float> plane = ramp(0, 1);
  ExrPicture picture = picture_of(plane, plane);
  picture.channels.clear();
  for (const char* name :
       {"R", "G", "B", "Z", "backward.u", "backward.v", "forward.u", "forward.v", "field.u", "field.v",
        "field.forward.u", "field.forward.v", "sigma", "confidence", "provenance"})
    picture.channels.push_back({name, plane.samples(), ExrSample::Half});
  std::vector<std::byte> bytes = encode_exr(picture).value();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::int32_t kLast[2] = {7679, 4319};  // x, y
  for (const std::string_view name : {"dataWindow", "displayWindow"}) {
    const std::size_t window = text.find(name);
    REQUIRE(window != std::string_view::npos);
    constexpr std::size_t kBeforeLast = std::string_view("\0box2i\0size", 11).size() + 2 * sizeof kLast[0];
    std::memcpy(bytes.data() + window + name.size() + kBeforeLast, kLast, sizeof kLast);
  }
  const auto image = decode_exr(bytes, "large.exr");
  REQUIRE_FALSE(image.ok());
  CHECK(image.error().code == ErrorCode::Truncated);  // there are too few bytes, not too many pixels
}

TEST_CASE("the picture of an OpenEXR file is what it displays, whatever part of it the file has data of") {
  Image<float> data(1, 64, 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) data.at(0, y, x) = static_cast<float>(100 * y + x + 1);
  ExrPicture picture;
  picture.rows = picture.cols = 64;
  picture.channels = {{"R", data.samples(), ExrSample::Float}};
  const auto displayed = [&](std::array<std::int32_t, 4> corners) {
    std::vector<std::byte> bytes = encode_exr(picture).value();
    show(corners, bytes);
    return decode_exr(bytes, "windows.exr");
  };
  const ExrImage part = displayed({8, 4, 55, 67}).value();  // four rows more than there are data
  REQUIRE(part.samples.cols() == 48);
  REQUIRE(part.samples.rows() == 64);
  CHECK(part.samples.at(0, 0, 0) == data.at(0, 4, 8));
  CHECK(part.samples.at(0, 59, 47) == data.at(0, 63, 55));
  CHECK(part.samples.at(0, 60, 0) == 0);
  const ExrImage apart = displayed({100, 100, 103, 101}).value();
  CHECK(apart.samples.cols() == 4);
  CHECK(apart.samples.at(0, 1, 3) == 0);
  const auto vast = displayed({0, 0, 65535, 1023});
  REQUIRE_FALSE(vast.ok());
  CHECK(vast.error().code == ErrorCode::Unsupported);
  CHECK(vast.error().message.find("1 channels of 64x64 in a picture of 65536x1024") != std::string::npos);
}

TEST_CASE("a displayed picture of more samples than a 64-bit size counts is refused") {
  const std::vector<float> grey(64 * 64, 0.5f);
  ExrPicture picture;
  picture.rows = picture.cols = 64;
  for (char c = 'a'; c < 'a' + 16; ++c) picture.channels.push_back({{c}, grey, ExrSample::Float});
  // (2^30 + 2^15) x (2^30 - 2^15 + 1) pixels of 16 channels: 2^64 + 2^19 samples.
  constexpr std::int32_t kFirst = -(1 << 29);
  std::vector<std::byte> bytes = encode_exr(picture).value();
  show({kFirst, kFirst, kFirst + (1 << 30) + (1 << 15) - 1, kFirst + (1 << 30) - (1 << 15)}, bytes);
  const auto vast = decode_exr(bytes, "vast.exr");
  REQUIRE_FALSE(vast.ok());
  CHECK(vast.error().code == ErrorCode::Unsupported);
}

TEST_CASE("bytes that are no OpenEXR file are refused by name, however few they are") {
  for (const std::string text : {"P6 2 2 255 nothing of the kind", "P6"}) {
    const auto image = decode_exr(std::as_bytes(std::span(text)), "holiday.ppm");
    REQUIRE_FALSE(image.ok());
    REQUIRE(image.error().code == ErrorCode::Corrupt);
    REQUIRE(image.error().message == "'holiday.ppm' is not an OpenEXR picture");
  }
}

TEST_CASE("an error of the OpenEXR library names the file once and has no full stop of its own") {
  const Image<float> plane = ramp(0, 1);
  std::vector<std::byte> bytes = encode_exr(picture_of(plane, plane)).value();
  bytes[4] = std::byte{77};  // a version that nobody has written
  const auto image = decode_exr(bytes, "newer.exr");
  REQUIRE_FALSE(image.ok());
  const std::string& message = image.error().message;
  CAPTURE(message);
  CHECK(message.starts_with("'newer.exr' is not a readable OpenEXR picture: "));
  CHECK(message.find("newer.exr") == message.rfind("newer.exr"));
  CHECK_FALSE(message.ends_with('.'));
}

}  // namespace hdrcam
