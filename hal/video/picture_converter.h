// Pictures from one pixel format, matrix, transfer and gamut to another, by zimg: radiance to the 10-bit
// Y'CbCr of a video, and the Y'CbCr of any video to RGB codes. Linear samples are luminance in cd/m2. Planes
// start, and rows are apart, at multiples of 64 bytes. Rounded to nearest, never dithered: the same picture
// gives the same codes. Thread-bound; the converter owns nothing but its work space.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/video/color_tags.h"

namespace hdrcam {

enum class PictureColors { Rgb, Yuv, Grey };
enum class CodeRange { Limited, Full };
enum class ChromaSite { Left, Center, TopLeft };
enum class SampleStore { Narrowest, Words };  // of codes of 8 bits: a byte, or two as of all others

struct PictureFormat {
  int width_px = 0, height_px = 0;
  int bits = 0;  // of a code, 8..16; 0: float
  SampleStore store = SampleStore::Narrowest;
  PictureColors colors = PictureColors::Rgb;
  int chroma_shift_x = 0, chroma_shift_y = 0;  // log2 of the subsampling
  ChromaSite chroma_site = ChromaSite::Left;
  CodeRange range = CodeRange::Full;
  ColorTags tags = {};

  int planes() const { return colors == PictureColors::Grey ? 1 : 3; }
};

// [planes] of [rows, cols]; order R G B or Y Cb Cr.
struct PicturePlanes {
  std::array<void*, 3> data{};
  std::array<std::ptrdiff_t, 3> stride_bytes{};
};
struct ConstPicturePlanes {
  ConstPicturePlanes(const PicturePlanes& of)
      : data{of.data[0], of.data[1], of.data[2]}, stride_bytes(of.stride_bytes) {}

  std::array<const void*, 3> data;
  std::array<std::ptrdiff_t, 3> stride_bytes;
};

// Of a picture whose rows are as long as PictureConverter::aligned_cols() says.
template <class Sample>
PicturePlanes planes_of(Image<Sample>& picture) {
  PicturePlanes planes;
  planes.stride_bytes.fill(static_cast<std::ptrdiff_t>(sizeof(Sample)) * picture.cols());
  for (int c = 0; c < picture.channels(); ++c) planes.data[static_cast<std::size_t>(c)] = picture.plane(c);
  return planes;
}

class PictureConverter {
 public:
  static constexpr int kAlignment_bytes = 64;
  // The length of rows, in samples, that hold so many and begin where they must.
  template <class Sample>
  static constexpr int aligned_cols(int cols) {
    constexpr int kStep = kAlignment_bytes / static_cast<int>(sizeof(Sample));
    return (cols + kStep - 1) / kStep * kStep;
  }

  // Errors: Unsupported where zimg knows no way from one to the other, with its words.
  static Result<PictureConverter> create(const PictureFormat& from, const PictureFormat& to);

  // Errors: Io with zimg's words.
  Result<void> convert(const ConstPicturePlanes& from, const PicturePlanes& to);

 private:
  struct FreeGraph {
    void operator()(void* graph) const;
  };
  struct FreeAligned {
    void operator()(std::byte* bytes) const;
  };

  PictureConverter() = default;

  int planes_from_ = 3, planes_to_ = 3;
  std::unique_ptr<void, FreeGraph> graph_;
  std::unique_ptr<std::byte, FreeAligned> work_;
};

}  // namespace hdrcam
