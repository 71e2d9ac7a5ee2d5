#include "firmware_host/sinks/canvas.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

#include "hal/core/check.h"

namespace hdrcam {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapitals_px = 21;  // height of the font's capitals at scale 1

std::array<std::uint8_t, 3> samples_of(Rgb colour) { return {colour.r, colour.g, colour.b}; }

// A view of one plane. cv::Mat has no const: the caller writes only to its own planes.
template <class T>
cv::Mat plane_of(const Image<T>& image, int channel) {
  return cv::Mat(image.rows(), image.cols(), cv::DataType<T>::type, const_cast<T*>(image.plane(channel)));
}

template <class T>
Image<T> resized_planes(const Image<T>& picture, int rows, int cols) {
  HDRCAM_CHECK_GT(picture.plane_size(), 0u);
  Image<T> result;
  result.reshape(picture.channels(), rows, cols);
  const bool smaller = rows <= picture.rows() && cols <= picture.cols();
  for (int c = 0; c < picture.channels(); ++c) {
    cv::Mat to = plane_of(result, c);
    cv::resize(plane_of(picture, c), to, to.size(), 0, 0, smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  }
  return result;
}

}  // namespace

Canvas::Canvas(int rows, int cols, Rgb background) {
  picture_.reshape(3, rows, cols);
  fill(0, 0, rows, cols, background);
}

void Canvas::fill(int top, int left, int rows, int cols, Rgb colour) {
  for (int c = 0; c < 3; ++c) {
    cv::Mat plane = plane_of(picture_, c);
    cv::rectangle(plane, cv::Rect(left, top, cols, rows), samples_of(colour)[static_cast<std::size_t>(c)],
                  cv::FILLED);
  }
}

void Canvas::paste(int top, int left, const Image<std::uint8_t>& picture) {
  const int y0 = std::max(0, -top), x0 = std::max(0, -left);  // of the picture, the first on the canvas
  const int rows = std::min(picture.rows(), picture_.rows() - top) - y0;
  const int cols = std::min(picture.cols(), picture_.cols() - left) - x0;
  if (rows <= 0 || cols <= 0) return;
  for (int c = 0; c < 3; ++c)
    for (int y = y0; y < y0 + rows; ++y)
      std::copy_n(picture.row(picture.channels() == 1 ? 0 : c, y) + x0, cols,
                  picture_.row(c, top + y) + left + x0);
}

void Canvas::write(int baseline, int left, const std::string& line, int height, Rgb colour) {
  for (int c = 0; c < 3; ++c) {
    cv::Mat plane = plane_of(picture_, c);
    cv::putText(plane, line, {left, baseline}, kFont, height / kCapitals_px,
                samples_of(colour)[static_cast<std::size_t>(c)], 1, cv::LINE_AA);
  }
}

int text_width(const std::string& line, int height) {
  int below_baseline = 0;
  return cv::getTextSize(line, kFont, height / kCapitals_px, 1, &below_baseline).width;
}

int rows_at_width(int rows, int cols, int width) { return std::max(1, rows * width / cols); }

Image<std::uint8_t> resized(const Image<std::uint8_t>& picture, int rows, int cols) {
  return resized_planes(picture, rows, cols);
}

Image<float> resized(const Image<float>& picture, int rows, int cols) {
  return resized_planes(picture, rows, cols);
}

Image<std::uint8_t> false_colours(const Image<std::uint8_t>& values) {
  cv::Mat bgr;
  cv::applyColorMap(plane_of(values, 0), bgr, cv::COLORMAP_INFERNO);
  Image<std::uint8_t> picture;
  picture.reshape(3, values.rows(), values.cols());
  for (int c = 0; c < 3; ++c) {
    cv::Mat plane = plane_of(picture, c);
    cv::extractChannel(bgr, plane, 2 - c);
  }
  return picture;
}

}  // namespace hdrcam
