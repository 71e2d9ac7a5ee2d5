#include "capture/pixel_unpack.h"

#include <algorithm>

namespace hdrcam {
namespace {

enum class Packing { Rgb, Bgr, Yuyv, Nv12, Jpeg, Bytes, Words, Mipi10, Mipi12 };

struct Format {
  Packing packing;
  PixelCodes codes;
};

Format format_of(PixelFormat format) {
  using enum PixelFormat;
  constexpr PixelLayout kBayer[] = {PixelLayout::BayerRggb, PixelLayout::BayerGrbg, PixelLayout::BayerGbrg,
                                    PixelLayout::BayerBggr};
  const auto bayer = [&](PixelFormat first, int bits, Packing packing) {
    return Format{packing, {kBayer[static_cast<int>(format) - static_cast<int>(first)], bits, true}};
  };
  switch (format) {
    case Rgb24:
      return {Packing::Rgb, {}};
    case Bgr24:
      return {Packing::Bgr, {}};
    case Yuyv:
      return {Packing::Yuyv, {}};
    case Nv12:
      return {Packing::Nv12, {}};
    case Mjpeg:
      return {Packing::Jpeg, {}};
    case Grey8:
      return {Packing::Bytes, {PixelLayout::Mono, 8, false}};
    case Rggb8:
    case Grbg8:
    case Gbrg8:
    case Bggr8:
      return bayer(Rggb8, 8, Packing::Bytes);
    case Rggb10:
    case Grbg10:
    case Gbrg10:
    case Bggr10:
      return bayer(Rggb10, 10, Packing::Words);
    case Rggb12:
    case Grbg12:
    case Gbrg12:
    case Bggr12:
      return bayer(Rggb12, 12, Packing::Words);
    case Rggb16:
    case Grbg16:
    case Gbrg16:
    case Bggr16:
      return bayer(Rggb16, 16, Packing::Words);
    case Rggb10Packed:
    case Grbg10Packed:
    case Gbrg10Packed:
    case Bggr10Packed:
      return bayer(Rggb10Packed, 10, Packing::Mipi10);
    case Rggb12Packed:
    case Grbg12Packed:
    case Gbrg12Packed:
    case Bggr12Packed:
      return bayer(Rggb12Packed, 12, Packing::Mipi12);
  }
  CHECK_EQ(static_cast<int>(format), -1);  // none of the list
  return {};
}

// Bytes of a row of the first plane.
std::size_t row_bytes(Packing packing, std::size_t width) {
  switch (packing) {
    case Packing::Rgb:
    case Packing::Bgr:
      return width * 3;
    case Packing::Yuyv:
    case Packing::Words:
      return width * 2;
    case Packing::Mipi10:
      return width / 4 * 5;
    case Packing::Mipi12:
      return width / 2 * 3;
    case Packing::Nv12:
    case Packing::Bytes:
    case Packing::Jpeg:
      break;
  }
  return width;
}

// Number of pixels that share bytes or samples: the width (and, for NV12, the height) must be a multiple of
// it.
int sharing(Packing packing) {
  if (packing == Packing::Mipi10) return 4;
  return packing == Packing::Yuyv || packing == Packing::Nv12 || packing == Packing::Mipi12 ? 2 : 1;
}

std::uint16_t byte(const std::byte* in, std::size_t i) { return std::to_integer<std::uint16_t>(in[i]); }

void unpack_rgb(const std::byte* in, int y, int red, int blue, Image<std::uint16_t>& codes) {
  std::uint16_t* r = codes.row(red, y);
  std::uint16_t* g = codes.row(1, y);
  std::uint16_t* b = codes.row(blue, y);
  for (int x = 0; x < codes.cols(); ++x, in += 3) r[x] = byte(in, 0), g[x] = byte(in, 1), b[x] = byte(in, 2);
}

// BT.601 with 16 fractional bits.
class YuvToRgb {
 public:
  explicit YuvToRgb(YuvRange range)
      : black_(range == YuvRange::Limited ? 16 : 0),
        luma_(range == YuvRange::Limited ? 76309 : 65536),
        chroma_(range == YuvRange::Limited ? 255.0 / 224.0 : 1.0) {}

  void convert(int y, int u, int v, Image<std::uint16_t>& codes, int row, int col) const {
    const int luma = luma_ * (y - black_) + 32768;
    codes.row(0, row)[col] = clamped(luma + scaled(1.402) * (v - 128));
    codes.row(1, row)[col] = clamped(luma - scaled(0.344136) * (u - 128) - scaled(0.714136) * (v - 128));
    codes.row(2, row)[col] = clamped(luma + scaled(1.772) * (u - 128));
  }

 private:
  int scaled(double weight) const { return static_cast<int>(weight * chroma_ * 65536 + 0.5); }
  static std::uint16_t clamped(int value) {
    return static_cast<std::uint16_t>(std::clamp(value >> 16, 0, 255));
  }

  int black_, luma_;
  double chroma_;
};

void unpack_yuyv(const std::byte* in, int y, const YuvToRgb& rgb, Image<std::uint16_t>& codes) {
  for (int x = 0; x < codes.cols(); x += 2, in += 4) {
    rgb.convert(byte(in, 0), byte(in, 1), byte(in, 3), codes, y, x);
    rgb.convert(byte(in, 2), byte(in, 1), byte(in, 3), codes, y, x + 1);
  }
}

void unpack_nv12(const std::byte* luma, const std::byte* chroma, int y, const YuvToRgb& rgb,
                 Image<std::uint16_t>& codes) {
  for (int x = 0; x < codes.cols(); ++x) {
    const auto pair = static_cast<std::size_t>(x & ~1);
    rgb.convert(byte(luma, static_cast<std::size_t>(x)), byte(chroma, pair), byte(chroma, pair + 1), codes, y,
                x);
  }
}

void unpack_raw(const std::byte* in, Packing packing, int bits, std::span<std::uint16_t> out) {
  const int most = (1 << bits) - 1;
  switch (packing) {
    case Packing::Bytes:
      for (std::size_t x = 0; x < out.size(); ++x) out[x] = byte(in, x);
      break;
    case Packing::Words:
      for (std::size_t x = 0; x < out.size(); ++x)
        out[x] = static_cast<std::uint16_t>(std::min(most, byte(in, 2 * x) | byte(in, 2 * x + 1) << 8));
      break;
    case Packing::Mipi10:  // four high bytes, then the low two bits of each, the first pixel's lowest
      for (std::size_t x = 0; x < out.size(); ++x) {
        const std::byte* group = in + x / 4 * 5;
        out[x] = static_cast<std::uint16_t>(byte(group, x % 4) << 2 | (byte(group, 4) >> 2 * (x % 4) & 3));
      }
      break;
    case Packing::Mipi12:
      for (std::size_t x = 0; x < out.size(); ++x) {
        const std::byte* group = in + x / 2 * 3;
        out[x] = static_cast<std::uint16_t>(byte(group, x % 2) << 4 | (byte(group, 2) >> 4 * (x % 2) & 15));
      }
      break;
    case Packing::Rgb:
    case Packing::Bgr:
    case Packing::Yuyv:
    case Packing::Nv12:
    case Packing::Jpeg:
      break;
  }
}

Result<void> decode_jpeg(const CapturedBuffer& buffer, const DecodeJpeg& decode,
                         Image<std::uint16_t>& codes) {
  if (!decode)
    return Error{ErrorCode::Unsupported, "MJPEG frames need a JPEG decoder; choose another pixel format"};
  if (buffer.mode.width <= 0 || buffer.mode.height <= 0)
    return Error{ErrorCode::Invalid,
                 fmt::format("a stream of {}x{} has no pixels", buffer.mode.width, buffer.mode.height)};
  codes.reshape(3, buffer.mode.height, buffer.mode.width);
  TRY(decode(buffer.pixels, codes));
  if (codes.rows() != buffer.mode.height || codes.cols() != buffer.mode.width || codes.channels() != 3)
    return Error{ErrorCode::Corrupt,
                 fmt::format("frame {} holds a JPEG of {}x{} where the stream is {}x{}", buffer.sequence,
                             codes.cols(), codes.rows(), buffer.mode.width, buffer.mode.height)};
  return {};
}

}  // namespace

PixelCodes codes_of(PixelFormat format) { return format_of(format).codes; }

Result<void> unpack_pixels(const CapturedBuffer& buffer, const PixelUnpackSettings& settings,
                           Image<std::uint16_t>& codes) {
  const auto [packing, kind] = format_of(buffer.mode.format);
  if (packing == Packing::Jpeg) return decode_jpeg(buffer, settings.decode_jpeg, codes);

  const int width = buffer.mode.width, height = buffer.mode.height, shared = sharing(packing);
  if (width <= 0 || height <= 0 || width % shared != 0 || (packing == Packing::Nv12 && height % 2 != 0))
    return Error{ErrorCode::Invalid,
                 fmt::format("a picture of {}x{} cannot have this pixel format, which shares "
                             "samples between {} pixels; choose another size",
                             width, height, shared)};
  const std::size_t tight = row_bytes(packing, static_cast<std::size_t>(width));
  const std::size_t stride = buffer.stride == 0 ? tight : buffer.stride;
  const auto rows = static_cast<std::size_t>(packing == Packing::Nv12 ? height + height / 2 : height);
  const std::size_t needed = stride * (rows - 1) + tight;
  if (stride < tight || buffer.pixels.size() < needed)
    return Error{ErrorCode::Corrupt,
                 fmt::format("frame {} has {} bytes in rows of {}; a {}x{} picture needs {} in rows of {}",
                             buffer.sequence, buffer.pixels.size(), stride, width, height, needed, tight)};

  codes.reshape(channels(kind.layout), height, width);
  const YuvToRgb rgb(settings.yuv_range);
  for (int y = 0; y < height; ++y) {
    const std::byte* row = buffer.pixels.data() + static_cast<std::size_t>(y) * stride;
    switch (packing) {
      case Packing::Rgb:
        unpack_rgb(row, y, 0, 2, codes);
        break;
      case Packing::Bgr:
        unpack_rgb(row, y, 2, 0, codes);
        break;
      case Packing::Yuyv:
        unpack_yuyv(row, y, rgb, codes);
        break;
      case Packing::Nv12:
        unpack_nv12(row, buffer.pixels.data() + static_cast<std::size_t>(height + y / 2) * stride, y, rgb,
                    codes);
        break;
      default:
        unpack_raw(row, packing, kind.bits, {codes.row(0, y), static_cast<std::size_t>(width)});
    }
  }
  return {};
}

}  // namespace hdrcam
