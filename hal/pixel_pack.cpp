#include "hal/pixel_pack.h"

namespace hdrcam {
namespace {

enum class Packing { Rgb, Bgr, Bytes, Words, Mipi10, Mipi12 };

constexpr PixelLayout kBayer[] = {PixelLayout::BayerRggb, PixelLayout::BayerGrbg, PixelLayout::BayerGbrg,
                                  PixelLayout::BayerBggr};

// The Bayer formats are in groups of four, in the order of kBayer.
struct Run {
  PixelFormat first;
  int bits;
  Packing packing;
  int multiple;  // of the width
};
constexpr Run kRuns[] = {
    {PixelFormat::Rggb8, 8, Packing::Bytes, 1},          {PixelFormat::Rggb10, 10, Packing::Words, 1},
    {PixelFormat::Rggb12, 12, Packing::Words, 1},        {PixelFormat::Rggb16, 16, Packing::Words, 1},
    {PixelFormat::Rggb10Packed, 10, Packing::Mipi10, 4}, {PixelFormat::Rggb12Packed, 12, Packing::Mipi12, 2},
};
const Run* run_of(PixelFormat format) {
  for (const Run& run : kRuns) {
    const int order = static_cast<int>(format) - static_cast<int>(run.first);
    if (order >= 0 && order < 4) return &run;
  }
  return nullptr;
}

Packing packing_of(PixelFormat format) {
  if (format == PixelFormat::Rgb24) return Packing::Rgb;
  if (format == PixelFormat::Bgr24) return Packing::Bgr;
  const Run* run = run_of(format);
  return run != nullptr ? run->packing : Packing::Bytes;
}

std::byte low(int code) { return static_cast<std::byte>(code & 0xff); }

void pack_rgb(const Image<std::uint16_t>& codes, int y, int first, int last, std::byte* out) {
  const std::uint16_t* a = codes.row(first, y);
  const std::uint16_t* b = codes.row(1, y);
  const std::uint16_t* c = codes.row(last, y);
  for (int x = 0; x < codes.cols(); ++x, out += 3) out[0] = low(a[x]), out[1] = low(b[x]), out[2] = low(c[x]);
}

void pack_words(const std::uint16_t* codes, int cols, std::byte* out) {
  for (int x = 0; x < cols; ++x, out += 2) out[0] = low(codes[x]), out[1] = low(codes[x] >> 8);
}

// MIPI CSI-2: the high bytes of a group of pixels, then their low bits, the first pixel's lowest.
void pack_mipi10(const std::uint16_t* codes, int cols, std::byte* out) {
  for (int x = 0; x + 3 < cols; x += 4, out += 5) {
    int rest = 0;
    for (int k = 0; k < 4; ++k) out[k] = low(codes[x + k] >> 2), rest |= (codes[x + k] & 3) << (2 * k);
    out[4] = low(rest);
  }
}
void pack_mipi12(const std::uint16_t* codes, int cols, std::byte* out) {
  for (int x = 0; x + 1 < cols; x += 2, out += 3) {
    out[0] = low(codes[x] >> 4), out[1] = low(codes[x + 1] >> 4);
    out[2] = low((codes[x] & 15) | (codes[x + 1] & 15) << 4);
  }
}

}  // namespace

std::optional<PackedFormat> packed_format(PixelFormat format) {
  if (format == PixelFormat::Rgb24 || format == PixelFormat::Bgr24) return PackedFormat{};
  if (format == PixelFormat::Grey8) return PackedFormat{PixelLayout::Mono, 8, 1};
  const Run* run = run_of(format);
  if (run == nullptr) return std::nullopt;
  const int order = static_cast<int>(format) - static_cast<int>(run->first);
  return PackedFormat{kBayer[order], run->bits, run->multiple};
}

std::optional<PixelFormat> format_for(PixelLayout layout, int bits) {
  if (layout == PixelLayout::Rgb) return bits == 8 ? std::optional(PixelFormat::Rgb24) : std::nullopt;
  if (layout == PixelLayout::Mono) return bits == 8 ? std::optional(PixelFormat::Grey8) : std::nullopt;
  for (const Run& run : kRuns)
    for (int order = 0; order < 4; ++order)
      if (run.bits == bits && kBayer[order] == layout)
        return static_cast<PixelFormat>(static_cast<int>(run.first) + order);
  return std::nullopt;
}

std::size_t packed_stride(PixelFormat format, int width) {
  const auto pixels = static_cast<std::size_t>(width);
  switch (packing_of(format)) {
    case Packing::Rgb:
    case Packing::Bgr:
      return 3 * pixels;
    case Packing::Words:
      return 2 * pixels;
    case Packing::Mipi10:
      return pixels / 4 * 5;
    case Packing::Mipi12:
      return pixels / 2 * 3;
    case Packing::Bytes:
      break;
  }
  return pixels;
}

void pack_codes(const Image<std::uint16_t>& codes, PixelFormat format, std::span<std::byte> bytes) {
  const std::size_t stride = packed_stride(format, codes.cols());
  CHECK_EQ(bytes.size(), stride * static_cast<std::size_t>(codes.rows()));
  const Packing packing = packing_of(format);
  for (int y = 0; y < codes.rows(); ++y) {
    std::byte* out = bytes.data() + static_cast<std::size_t>(y) * stride;
    const std::uint16_t* row = codes.row(0, y);
    switch (packing) {
      case Packing::Rgb:
        pack_rgb(codes, y, 0, 2, out);
        break;
      case Packing::Bgr:
        pack_rgb(codes, y, 2, 0, out);
        break;
      case Packing::Words:
        pack_words(row, codes.cols(), out);
        break;
      case Packing::Mipi10:
        pack_mipi10(row, codes.cols(), out);
        break;
      case Packing::Mipi12:
        pack_mipi12(row, codes.cols(), out);
        break;
      case Packing::Bytes:
        for (int x = 0; x < codes.cols(); ++x) out[x] = low(row[x]);
        break;
    }
  }
}

}  // namespace hdrcam
