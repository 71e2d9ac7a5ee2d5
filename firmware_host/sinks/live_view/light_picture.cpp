#include "firmware_host/sinks/live_view/light_picture.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "firmware_host/sinks/canvas.h"
#include "firmware_host/sinks/live_view/frame_picture.h"
#include "hal/recording/png_image.h"
#include "render/display_light.h"

namespace hdrcam {
namespace {

constexpr int kBits = 10;
constexpr ColorTags kTags{h273::kPrimariesBt2020, h273::kTransferPq, h273::kMatrixRgb};

// Full scale stays full scale.
std::uint16_t widened(std::uint16_t code) { return static_cast<std::uint16_t>(code << 6 | code >> 4); }

}  // namespace

Result<void> LightPicture::fit_to(int rows, int cols) {
  if (converter_ && rows == rows_ && cols == cols_) return {};
  PictureFormat light, signal;
  light.width_px = signal.width_px = cols, light.height_px = signal.height_px = rows;
  light.tags = {h273::kPrimariesBt2020, h273::kTransferLinear, h273::kMatrixRgb};
  signal.tags = kTags;
  signal.bits = kBits, signal.store = SampleStore::Words;
  converter_ = TRY(PictureConverter::create(light, signal));
  const int pitch = PictureConverter::aligned_cols<std::uint16_t>(cols);  // more than enough for floats
  light_ = Image<float>(3, rows, pitch);
  signal_ = Image<std::uint16_t>(3, rows, pitch);
  rows_ = rows, cols_ = cols;
  return {};
}

Result<void> LightPicture::convert(const Image<float>& radiance) {
  TRY(converter_->convert(planes_of(light_), planes_of(signal_)));
  PngImage picture{16, Image<std::uint16_t>(3, radiance.rows(), radiance.cols()),
                   PngColors{h273::kPrimariesBt2020, h273::kTransferPq}};
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < radiance.rows(); ++y)
      std::transform(signal_.row(c, y), signal_.row(c, y) + radiance.cols(), picture.samples.row(c, y),
                     widened);
  encoded_ = std::make_shared<const std::vector<std::byte>>(TRY(png_file(picture, PngEase::Fast)));
  return {};
}

Result<HttpBody> LightPicture::png(const ShownFrame& frame, double exposure_ev) {
  if (sequence_ == frame.hdr.facts.sequence && exposure_ev_ == exposure_ev) return encoded_;
  sequence_.reset();
  const Image<float>* radiance = &frame.hdr.radiance;
  Image<float> smaller;
  if (radiance->cols() > FramePicture::kWidest_px) {
    smaller = resized(*radiance, rows_at_width(radiance->rows(), radiance->cols(), FramePicture::kWidest_px),
                      FramePicture::kWidest_px);
    radiance = &smaller;
  }
  TRY(fit_to(radiance->rows(), radiance->cols()));
  DisplayLight(options_.white_nits * std::exp2(exposure_ev), options_.peak_nits,
               static_cast<double>(frame.hdr.white))
      .show(*radiance, light_);
  TRY(convert(*radiance));
  sequence_ = frame.hdr.facts.sequence, exposure_ev_ = exposure_ev;
  return encoded_;
}

}  // namespace hdrcam
