#include "capture/pixel_unpack.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "capture/demosaic.h"
#include "capture/to_exposed_frame.h"
#include "hal/pixel_pack.h"
#include "tests/capture/plain_demosaic.h"

namespace hdrcam {
namespace {

struct Bytes {
  std::vector<std::byte> data;
  void put(int value) { data.push_back(static_cast<std::byte>(value)); }
};

CapturedBuffer buffer_of(PixelFormat format, int width, int height, std::span<const std::byte> pixels,
                         std::size_t stride = 0) {
  CapturedBuffer buffer;
  buffer.mode = {format, width, height, Duration(1)};
  buffer.pixels = pixels;
  buffer.stride = stride;
  return buffer;
}

std::vector<std::uint16_t> random_codes(int count, int bits) {
  std::mt19937 random(11);
  std::vector<std::uint16_t> codes(static_cast<std::size_t>(count));
  for (auto& code : codes) code = static_cast<std::uint16_t>(random() & ((1u << bits) - 1));
  return codes;
}

TEST_CASE("raw codes come out as they went in, packed or not, with any stride", "[capture]") {
  constexpr int kWidth = 12, kHeight = 6;
  for (const auto& [format, bits] : {std::pair{PixelFormat::Grbg8, 8},
                                     {PixelFormat::Grbg10, 10},
                                     {PixelFormat::Grbg12, 12},
                                     {PixelFormat::Grbg16, 16},
                                     {PixelFormat::Grbg10Packed, 10},
                                     {PixelFormat::Grbg12Packed, 12}}) {
    const bool packed = format == PixelFormat::Grbg10Packed || format == PixelFormat::Grbg12Packed;
    const auto codes = random_codes(kWidth * kHeight, bits);
    for (const std::size_t padding : {0u, 5u}) {
      Bytes bytes;
      std::size_t stride = 0;
      for (int y = 0; y < kHeight; ++y) {
        const std::uint16_t* row = codes.data() + y * kWidth;
        if (!packed) {
          for (int x = 0; x < kWidth; ++x) {
            bytes.put(row[x] & 255);
            if (bits > 8) bytes.put(row[x] >> 8);
          }
        } else if (bits == 10) {
          for (int x = 0; x < kWidth; x += 4) {
            for (int i = 0; i < 4; ++i) bytes.put(row[x + i] >> 2);
            bytes.put((row[x] & 3) | (row[x + 1] & 3) << 2 | (row[x + 2] & 3) << 4 | (row[x + 3] & 3) << 6);
          }
        } else {
          for (int x = 0; x < kWidth; x += 2) {
            for (int i = 0; i < 2; ++i) bytes.put(row[x + i] >> 4);
            bytes.put((row[x] & 15) | (row[x + 1] & 15) << 4);
          }
        }
        for (std::size_t i = 0; i < padding; ++i) bytes.put(0xee);
        if (y == 0) stride = bytes.data.size();
      }
      Image<std::uint16_t> out;
      REQUIRE(unpack_pixels(buffer_of(format, kWidth, kHeight, bytes.data, stride), {}, out).ok());
      REQUIRE(out.channels() == 1);
      CHECK(std::equal(codes.begin(), codes.end(), out.samples().begin()));
      CHECK(codes_of(format).bits == bits);
      CHECK(codes_of(format).layout == PixelLayout::BayerGrbg);
      CHECK(codes_of(format).linear);

      const auto cut =
          unpack_pixels(buffer_of(format, kWidth, kHeight,
                                  std::span(bytes.data).first(bytes.data.size() - padding - 1), stride),
                        {}, out);
      REQUIRE_FALSE(cut.ok());
      CHECK(cut.error().code == ErrorCode::Corrupt);
    }
  }
}

TEST_CASE("mono of more than 8 bits has the sensor's own codes: as they went in, and linear", "[capture]") {
  constexpr int kWidth = 12, kHeight = 3;
  for (const auto& [format, bits] :
       {std::pair{PixelFormat::Grey10, 10}, {PixelFormat::Grey12, 12}, {PixelFormat::Grey10Packed, 10}}) {
    CAPTURE(name(format));
    Image<std::uint16_t> in(1, kHeight, kWidth), out;
    std::ranges::copy(random_codes(kWidth * kHeight, bits), in.samples().begin());
    std::vector<std::byte> bytes(packed_stride(format, kWidth) * kHeight);
    pack_codes(in, format, bytes);
    REQUIRE(unpack_pixels(buffer_of(format, kWidth, kHeight, bytes), {}, out).ok());
    REQUIRE(out.channels() == 1);
    CHECK(std::ranges::equal(in.samples(), out.samples()));
    CHECK(codes_of(format).bits == bits);
    CHECK(codes_of(format).layout == PixelLayout::Mono);
    CHECK(codes_of(format).linear);
  }
  CHECK_FALSE(codes_of(PixelFormat::Grey8).linear);  // of any camera
}

TEST_CASE("words beyond the bits of their format are cut off, so that no code is out of range", "[capture]") {
  Bytes bytes;
  for (int i = 0; i < 4; ++i) bytes.put(0xff), bytes.put(0xff);
  Image<std::uint16_t> out;
  REQUIRE(unpack_pixels(buffer_of(PixelFormat::Rggb10, 2, 2, bytes.data), {}, out).ok());
  CHECK(out.at(0, 1, 1) == 1023);
}

TEST_CASE("RGB and BGR differ in the order of their bytes only", "[capture]") {
  Bytes bytes;
  for (int i = 0; i < 12; ++i) bytes.put(10 * i);
  Image<std::uint16_t> rgb, bgr;
  REQUIRE(unpack_pixels(buffer_of(PixelFormat::Rgb24, 2, 2, bytes.data), {}, rgb).ok());
  REQUIRE(unpack_pixels(buffer_of(PixelFormat::Bgr24, 2, 2, bytes.data), {}, bgr).ok());
  CHECK((rgb.at(0, 0, 1) == 30 && rgb.at(1, 0, 1) == 40 && rgb.at(2, 0, 1) == 50));
  CHECK((bgr.at(2, 0, 1) == 30 && bgr.at(1, 0, 1) == 40 && bgr.at(0, 0, 1) == 50));
}

TEST_CASE("YUV becomes the RGB of BT.601, limited or full range", "[capture]") {
  // Black, white and the primary red of a limited-range signal.
  const int kPairs[][4] = {{16, 128, 16, 128}, {235, 128, 235, 128}, {81, 90, 81, 240}};
  const int kExpected[][3] = {{0, 0, 0}, {255, 255, 255}, {254, 0, 0}};
  for (int i = 0; i < 3; ++i) {
    Bytes yuyv, nv12;
    for (int row = 0; row < 2; ++row)
      for (const int value : kPairs[i]) yuyv.put(value);
    for (int k = 0; k < 4; ++k) nv12.put(kPairs[i][0]);
    nv12.put(kPairs[i][1]), nv12.put(kPairs[i][3]);
    Image<std::uint16_t> a, b;
    REQUIRE(unpack_pixels(buffer_of(PixelFormat::Yuyv, 2, 2, yuyv.data), {}, a).ok());
    REQUIRE(unpack_pixels(buffer_of(PixelFormat::Nv12, 2, 2, nv12.data), {}, b).ok());
    for (int c = 0; c < 3; ++c) {
      CHECK(a.at(c, 1, 1) == kExpected[i][c]);
      CHECK(b.at(c, 1, 1) == kExpected[i][c]);
    }
  }
  Bytes grey;
  for (int i = 0; i < 4; ++i) grey.put(77), grey.put(128);
  Image<std::uint16_t> full;
  REQUIRE(unpack_pixels(buffer_of(PixelFormat::Yuyv, 2, 2, grey.data),
                        {.yuv_range = YuvRange::Full, .decode_jpeg = {}}, full)
              .ok());
  CHECK(full.at(1, 0, 0) == 77);
}

TEST_CASE("YUV becomes RGB as the camera states its matrix and range - unless the range is set",
          "[capture]") {
  // the primary red and a grey of each, limited and full: luma, Cb, Cr (ITU-R BT.601, BT.709, BT.2020)
  struct Signal {
    YuvCoding coding;
    int red[3];
  };
  const Signal kSignals[] = {{{YuvMatrix::Bt601, YuvRange::Limited}, {81, 90, 240}},
                             {{YuvMatrix::Bt709, YuvRange::Limited}, {63, 102, 240}},
                             {{YuvMatrix::Bt2020, YuvRange::Limited}, {74, 97, 240}},
                             {{YuvMatrix::Bt601, YuvRange::Full}, {76, 85, 255}},
                             {{YuvMatrix::Bt709, YuvRange::Full}, {54, 99, 255}}};
  for (const auto& [coding, red] : kSignals) {
    Bytes bytes;
    for (int i = 0; i < 2; ++i) bytes.put(red[0]), bytes.put(red[1]), bytes.put(red[0]), bytes.put(red[2]);
    CapturedBuffer buffer = buffer_of(PixelFormat::Yuyv, 2, 2, bytes.data);
    buffer.yuv = coding;
    Image<std::uint16_t> as_stated, as_full;
    REQUIRE(unpack_pixels(buffer, {}, as_stated).ok());
    CAPTURE(static_cast<int>(coding.matrix), static_cast<int>(coding.range));
    CHECK(as_stated.at(0, 1, 1) >= 253);
    CHECK(as_stated.at(1, 1, 1) <= 1);
    CHECK(as_stated.at(2, 1, 1) <= 2);
    REQUIRE(unpack_pixels(buffer, {.yuv_range = YuvRange::Full, .decode_jpeg = {}}, as_full).ok());
    CHECK((as_full.at(1, 1, 1) == as_stated.at(1, 1, 1)) == (coding.range == YuvRange::Full));
  }
}

TEST_CASE("UYVY is YUYV with luma and chroma in the other order", "[capture]") {
  Bytes yuyv, uyvy;
  for (int pair = 0; pair < 6; ++pair) {
    const int y0 = 40 + 30 * pair, u = 90 + 10 * pair, y1 = 50 + 25 * pair, v = 180 - 12 * pair;
    for (const int value : {y0, u, y1, v}) yuyv.put(value);
    for (const int value : {u, y0, v, y1}) uyvy.put(value);
  }
  Image<std::uint16_t> a, b;
  REQUIRE(unpack_pixels(buffer_of(PixelFormat::Yuyv, 6, 2, yuyv.data), {}, a).ok());
  REQUIRE(unpack_pixels(buffer_of(PixelFormat::Uyvy, 6, 2, uyvy.data), {}, b).ok());
  CHECK(a.at(0, 0, 0) != a.at(0, 0, 1));
  CHECK(std::ranges::equal(a.samples(), b.samples()));
  CHECK(unpack_pixels(buffer_of(PixelFormat::Uyvy, 3, 2, uyvy.data), {}, b).error().code ==
        ErrorCode::Invalid);
}

TEST_CASE("MJPEG goes through the decoder that was supplied", "[capture]") {
  const std::byte jpeg[] = {std::byte{0xff}, std::byte{0xd8}};
  Image<std::uint16_t> out;
  CHECK(unpack_pixels(buffer_of(PixelFormat::Mjpeg, 4, 2, jpeg), {}, out).error().code ==
        ErrorCode::Unsupported);
  PixelUnpackSettings settings;
  settings.decode_jpeg = [](std::span<const std::byte> bytes, Image<std::uint16_t>& rgb) -> Result<void> {
    CHECK(rgb.rows() == 2);
    rgb.reshape(3, 2, static_cast<int>(bytes.size()) * 2);
    rgb.fill(5);
    return {};
  };
  REQUIRE(unpack_pixels(buffer_of(PixelFormat::Mjpeg, 4, 2, jpeg), settings, out).ok());
  CHECK(out.at(2, 1, 3) == 5);
  CHECK(unpack_pixels(buffer_of(PixelFormat::Mjpeg, 6, 2, jpeg), settings, out).error().code ==
        ErrorCode::Corrupt);
}

TEST_CASE("sizes that a format cannot have are refused", "[capture]") {
  const std::vector<std::byte> bytes(1000);
  Image<std::uint16_t> out;
  CHECK(unpack_pixels(buffer_of(PixelFormat::Yuyv, 3, 2, bytes), {}, out).error().code == ErrorCode::Invalid);
  CHECK(unpack_pixels(buffer_of(PixelFormat::Rggb10Packed, 6, 2, bytes), {}, out).error().code ==
        ErrorCode::Invalid);
  CHECK(unpack_pixels(buffer_of(PixelFormat::Nv12, 4, 3, bytes), {}, out).error().code == ErrorCode::Invalid);
  CHECK(unpack_pixels(buffer_of(PixelFormat::Rgb24, 0, 3, bytes), {}, out).error().code ==
        ErrorCode::Invalid);
}

// The mosaic that a Bayer sensor would see of a coloured picture.
Image<std::uint16_t> mosaic_of(PixelLayout layout, int rows, int cols, auto&& colour) {
  const int red_x = layout == PixelLayout::BayerGrbg || layout == PixelLayout::BayerBggr;
  const int red_y = layout == PixelLayout::BayerGbrg || layout == PixelLayout::BayerBggr;
  Image<std::uint16_t> mosaic(1, rows, cols);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      const bool red_row = (y & 1) == red_y, red_col = (x & 1) == red_x;
      mosaic.at(0, y, x) =
          static_cast<std::uint16_t>(colour(red_row == red_col ? (red_row ? 0 : 2) : 1, y, x));
    }
  }
  return mosaic;
}

constexpr PixelLayout kBayer[] = {PixelLayout::BayerRggb, PixelLayout::BayerGrbg, PixelLayout::BayerGbrg,
                                  PixelLayout::BayerBggr};

TEST_CASE("demosaicing keeps what is constant or linear, in every layout", "[capture]") {
  // The same slope in all channels: what the gradient correction assumes.
  const auto colour = [](int c, int y, int x) { return 200 + 100 * c + 4 * x + 8 * y; };
  for (const PixelLayout layout : kBayer) {
    Image<float> rgb;
    demosaic(mosaic_of(layout, 17, 22, colour), layout, 1023, rgb);
    float worst = 0;
    for (int c = 0; c < 3; ++c)
      for (int y = 3; y < 14; ++y)  // the filter reaches three pixels far
        for (int x = 3; x < 19; ++x)
          worst = std::max(worst, std::abs(rgb.at(c, y, x) - static_cast<float>(colour(c, y, x))));
    CHECK(worst < 1e-3f);

    const auto flat = [](int c, int, int) { return 100 + 300 * c; };
    demosaic(mosaic_of(layout, 4, 4, flat), layout, 1023, rgb);
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < 16; ++i) CHECK(rgb.plane(c)[i] == Approx(100 + 300 * c));
  }
}

TEST_CASE("demosaicing is the same as pixel by pixel, in every layout and at every border",
          "[capture][isa]") {
  constexpr struct {
    int rows, cols;
  } kSizes[] = {{2, 2}, {2, 3}, {3, 2}, {5, 63}, {6, 64}, {7, 65}, {4, 66}, {9, 67}, {4, 130}, {33, 191}};
  std::mt19937 random(5);
  for (const auto [rows, cols] : kSizes)
    for (const PixelLayout layout : kBayer) {
      INFO(rows << "x" << cols << ", layout " << static_cast<int>(layout));
      const auto mosaic =
          mosaic_of(layout, rows, cols, [&](int, int, int) { return static_cast<int>(random() & 0xffff); });
      const bool red_right = layout == PixelLayout::BayerGrbg || layout == PixelLayout::BayerBggr,
                 red_low = layout == PixelLayout::BayerGbrg || layout == PixelLayout::BayerBggr;
      Image<float> plain, found;
      test::plain_demosaic(mosaic, {.x = red_right, .y = red_low}, 60000, plain);
      demosaic(mosaic, layout, 60000, found, 0.5f);
      std::size_t wrong = 0;
      for (std::size_t i = 0; i < plain.size(); ++i) wrong += found.plane(0)[i] != 0.5f * plain.plane(0)[i];
      CHECK(wrong == 0);
    }
}

TEST_CASE("the border of something clipped neither rings nor takes on colour", "[capture]") {
  constexpr int kDark = 20, kClipped = 1023;
  const auto lower = [](int, int y, int) { return y < 9 ? kDark : kClipped; };
  const auto right = [](int, int, int x) { return x < 11 ? kDark : kClipped; };
  for (const PixelLayout layout : kBayer)
    for (const bool upright : {false, true}) {
      Image<float> rgb;
      demosaic(upright ? mosaic_of(layout, 18, 22, right) : mosaic_of(layout, 18, 22, lower), layout,
               kClipped, rgb);
      for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 22; ++x)
          for (int c = 0; c < 3; ++c)
            CHECK(rgb.at(c, y, x) == static_cast<float>(upright ? right(c, y, x) : lower(c, y, x)));
    }
}

TEST_CASE("a Bayer frame becomes an exposed frame of three channels", "[capture]") {
  RawFrame raw;
  raw.facts.exposure_s = 0.004;
  raw.codes = mosaic_of(PixelLayout::BayerGbrg, 6, 8, [](int c, int, int) { return 341 * (c + 1); });
  const ExposedFrameSettings settings{
      .bits = 10, .reference_exposure = 0.004, .layout = PixelLayout::BayerGbrg};
  ExposedFrame frame;
  REQUIRE(to_exposed_frame(raw, 0, 0.033, settings, frame).ok());
  for (int c = 0; c < 3; ++c) CHECK(frame.codes.at(c, 3, 3) == Approx(85.0 * (c + 1)));
  CHECK(frame.exposure == 1);
}

}  // namespace
}  // namespace hdrcam
