#include "capture/pixel_unpack.h"

#include <algorithm>

#include "hal/pixel_format_table.h"

namespace hdrcam {
namespace {

std::uint16_t byte(const std::byte* in, std::size_t i) { return std::to_integer<std::uint16_t>(in[i]); }

// first, last: the channels of the first and the last byte of a pixel; green is between them.
void unpack_rgb(const std::byte* in, int y, int first, int last, Image<std::uint16_t>& codes) {
  std::uint16_t *of_first = codes.row(first, y), *green = codes.row(1, y), *of_last = codes.row(last, y);
  for (int x = 0; x < codes.cols(); ++x, in += 3)
    of_first[x] = byte(in, 0), green[x] = byte(in, 1), of_last[x] = byte(in, 2);
}

// The shares of red and blue in luma: ITU-R BT.601-7, 2.5.1; BT.709-6, 3.2; BT.2020-2, table 4.
struct LumaShares {
  double red, blue;
};
LumaShares luma_shares(YuvMatrix matrix) {
  switch (matrix) {
    case YuvMatrix::Bt601:
      break;
    case YuvMatrix::Bt709:
      return {0.2126, 0.0722};
    case YuvMatrix::Bt2020:
      return {0.2627, 0.0593};
  }
  return {0.299, 0.114};
}

// With 16 fractional bits.
class YuvToRgb {
 public:
  YuvToRgb(YuvMatrix matrix, YuvRange range) {
    const bool limited = range == YuvRange::Limited;
    const auto [red, blue] = luma_shares(matrix);
    const double chroma = limited ? 255.0 / 224.0 : 1, green = 1 - red - blue;
    black_ = limited ? 16 : 0;
    luma_ = fixed(limited ? 255.0 / 219.0 : 1);
    red_of_v_ = fixed(chroma * 2 * (1 - red)), blue_of_u_ = fixed(chroma * 2 * (1 - blue));
    green_of_u_ = fixed(chroma * 2 * (1 - blue) * blue / green);
    green_of_v_ = fixed(chroma * 2 * (1 - red) * red / green);
  }

  void convert(int y, int u, int v, Image<std::uint16_t>& codes, int row, int col) const {
    const int luma = luma_ * (y - black_) + 32768;
    codes.row(0, row)[col] = clamped(luma + red_of_v_ * (v - 128));
    codes.row(1, row)[col] = clamped(luma - green_of_u_ * (u - 128) - green_of_v_ * (v - 128));
    codes.row(2, row)[col] = clamped(luma + blue_of_u_ * (u - 128));
  }

 private:
  static int fixed(double weight) { return static_cast<int>(weight * 65536 + 0.5); }
  static std::uint16_t clamped(int value) {
    return static_cast<std::uint16_t>(std::clamp(value >> 16, 0, 255));
  }

  int black_, luma_;
  int red_of_v_, green_of_u_, green_of_v_, blue_of_u_;
};

// luma: the first of its bytes, 0 or 1; chroma has the others.
void unpack_pairs(const std::byte* in, std::size_t luma, int y, const YuvToRgb& rgb,
                  Image<std::uint16_t>& codes) {
  const std::size_t chroma = 1 - luma;
  for (int x = 0; x < codes.cols(); x += 2, in += 4) {
    const int u = byte(in, chroma), v = byte(in, chroma + 2);
    rgb.convert(byte(in, luma), u, v, codes, y, x);
    rgb.convert(byte(in, luma + 2), u, v, codes, y, x + 1);
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
    case Packing::Uyvy:
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

// Bytes from row to row of a buffer that holds all of its picture.
Result<std::size_t> stride_of(const CapturedBuffer& buffer, Packing packing) {
  const int width = buffer.mode.width, height = buffer.mode.height, shared = sharing(packing);
  if (width <= 0 || height <= 0 || width % shared != 0 || (packing == Packing::Nv12 && height % 2 != 0))
    return Error{ErrorCode::Invalid,
                 fmt::format("a picture of {}x{} cannot have this pixel format, which shares "
                             "samples between {} pixels; choose another size",
                             width, height, shared)};
  const std::size_t tight = row_bytes(packing, width);
  const std::size_t stride = buffer.stride == 0 ? tight : buffer.stride;
  const std::size_t needed = picture_bytes(packing, width, height, stride);
  if (stride < tight || buffer.pixels.size() < needed)
    return Error{ErrorCode::Corrupt,
                 fmt::format("frame {} has {} bytes in rows of {}; a {}x{} picture needs {} in rows of {}",
                             buffer.sequence, buffer.pixels.size(), stride, width, height, needed, tight)};
  return stride;
}

}  // namespace

PixelCodes codes_of(PixelFormat format) {
  const auto [packing, layout, bits] = packing_of(format);
  return {layout, bits, is_raw(format)};
}

Result<void> unpack_pixels(const CapturedBuffer& buffer, const PixelUnpackSettings& settings,
                           Image<std::uint16_t>& codes) {
  const auto [packing, layout, bits] = packing_of(buffer.mode.format);
  if (packing == Packing::Jpeg) return decode_jpeg(buffer, settings.decode_jpeg, codes);

  const std::size_t stride = TRY(stride_of(buffer, packing));
  const int width = buffer.mode.width, height = buffer.mode.height;
  codes.reshape(channels(layout), height, width);
  const YuvCoding& yuv = buffer.yuv;
  const YuvToRgb rgb(yuv.matrix, settings.yuv_range.value_or(yuv.range));
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
        unpack_pairs(row, 0, y, rgb, codes);
        break;
      case Packing::Uyvy:
        unpack_pairs(row, 1, y, rgb, codes);
        break;
      case Packing::Nv12:
        unpack_nv12(row, buffer.pixels.data() + static_cast<std::size_t>(height + y / 2) * stride, y, rgb,
                    codes);
        break;
      default:
        unpack_raw(row, packing, bits, {codes.row(0, y), static_cast<std::size_t>(width)});
    }
  }
  return {};
}

}  // namespace hdrcam
