// What the numbers of a picture mean to a display: code points of ITU-T H.273, which FFmpeg, zimg and the
// files themselves all use. Plain values; reentrant.
#pragma once

namespace hdrcam {

namespace h273 {
inline constexpr int kUnspecified = 2;
inline constexpr int kPrimariesBt709 = 1, kPrimariesBt2020 = 9;
inline constexpr int kTransferBt709 = 1, kTransferLinear = 8, kTransferSrgb = 13, kTransferPq = 16,
                     kTransferHlg = 18;
inline constexpr int kMatrixRgb = 0, kMatrixBt709 = 1, kMatrixBt601 = 6, kMatrixBt2020Ncl = 9;
}  // namespace h273

struct ColorTags {
  int primaries = h273::kUnspecified, transfer = h273::kUnspecified, matrix = h273::kUnspecified;

  friend bool operator==(const ColorTags&, const ColorTags&) = default;
};

}  // namespace hdrcam
