// A picture for composing: paste, fill, write. 8-bit sRGB; (top, left) in pixels from the upper left corner;
// parts outside are clipped. The only file of the sinks that draws with OpenCV. Value type.
#pragma once

#include <cstdint>
#include <string>

#include "firmware_host/sinks/rgb.h"
#include "hal/core/image.h"

namespace hdrcam {

class Canvas {
 public:
  Canvas(int rows, int cols, Rgb background);

  void fill(int top, int left, int rows, int cols, Rgb colour);
  void paste(int top, int left, const Image<std::uint8_t>& picture);  // [1 or rgb, rows, cols]
  // One line of ASCII whose capitals are `height` pixels high and stand on `baseline`.
  void write(int baseline, int left, const std::string& line, int height, Rgb colour);

  const Image<std::uint8_t>& picture() const { return picture_; }  // [rgb, rows, cols]

 private:
  Image<std::uint8_t> picture_;
};

// The width in pixels of a line that Canvas::write would draw.
int text_width(const std::string& line, int height);

// The rows of a picture of rows x cols that is made so wide in its shape; at least one.
int rows_at_width(int rows, int cols, int width);
// Averaged down (or interpolated up) to rows x cols.
Image<std::uint8_t> resized(const Image<std::uint8_t>& picture, int rows, int cols);
Image<float> resized(const Image<float>& picture, int rows, int cols);

// [1, rows, cols] 0..255 -> [rgb, rows, cols], dark to bright (OpenCV's "inferno").
Image<std::uint8_t> false_colours(const Image<std::uint8_t>& values);

}  // namespace hdrcam
