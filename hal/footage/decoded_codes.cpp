#include "hal/footage/decoded_codes.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace hdrcam {
namespace {

int rounded_up(int value, int shift) { return (value + (1 << shift) - 1) >> shift << shift; }

// What players (mpv, libplacebo) take for it, and so for BT.709, where a video states no matrix.
bool is_high_definition(const AVFrame& frame) {
  constexpr int kLeastWidth_px = 1280, kMostStandardRows = 576;
  return frame.width >= kLeastWidth_px || frame.height > kMostStandardRows;
}

int matrix_of(const AVFrame& frame, AVCodecID codec) {
  if (frame.colorspace != AVCOL_SPC_UNSPECIFIED) return frame.colorspace;
  if (codec == AV_CODEC_ID_MJPEG) return h273::kMatrixBt601;  // JFIF
  return is_high_definition(frame) ? h273::kMatrixBt709 : h273::kMatrixBt601;
}

bool is_full_range(const AVFrame& frame) {
  const std::string_view name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
  return frame.color_range == AVCOL_RANGE_JPEG || name.starts_with("yuvj");
}

ChromaSite chroma_site_of(const AVFrame& frame) {
  switch (frame.chroma_location) {
    case AVCHROMA_LOC_CENTER:
      return ChromaSite::Center;
    case AVCHROMA_LOC_TOPLEFT:
      return ChromaSite::TopLeft;
    default:
      return ChromaSite::Left;
  }
}

}  // namespace

Result<void> DecodedCodes::begin(const AVFrame& frame, AVCodecID codec) {
  TRY(take_format(frame, codec));
  unpacked_ = Image<std::uint16_t>(from_.planes(), from_.height_px,
                                   PictureConverter::aligned_cols<std::uint16_t>(from_.width_px));
  const bool are_wanted = from_.colors != PictureColors::Yuv && from_.range == CodeRange::Full;
  return are_wanted ? Result<void>{} : open_converter();
}

// What its codes are.
Result<void> DecodedCodes::take_format(const AVFrame& frame, AVCodecID codec) {
  const auto pixel_format = static_cast<AVPixelFormat>(frame.format);
  const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(pixel_format);
  constexpr std::uint64_t kNoCodes = AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_HWACCEL;
  if ((format.flags & AV_PIX_FMT_FLAG_BAYER) != 0)
    return Error{
        ErrorCode::Unsupported,
        fmt::format("has pixels of the format {}, a mosaic; write its codes as grey PNG pictures, with a "
                    "clip.json that states the layout (docs/recording.md)",
                    format.name)};
  const bool xyz = pixel_format == AV_PIX_FMT_XYZ12LE || pixel_format == AV_PIX_FMT_XYZ12BE;
  if ((format.flags & kNoCodes) != 0 || xyz || format.comp[0].depth < 8 || format.comp[0].depth > 16)
    return Error{ErrorCode::Unsupported,
                 fmt::format("has pixels of the format {}; convert it to RGB of 8 to 16 bits", format.name)};
  pixel_format_ = pixel_format;

  const bool rgb = (format.flags & AV_PIX_FMT_FLAG_RGB) != 0, grey = format.nb_components < 3;
  from_ = {};
  from_.store = SampleStore::Words;
  from_.bits = format.comp[0].depth;
  from_.colors = grey ? PictureColors::Grey : rgb ? PictureColors::Rgb : PictureColors::Yuv;
  if (from_.colors == PictureColors::Yuv)
    from_.chroma_shift_x = format.log2_chroma_w, from_.chroma_shift_y = format.log2_chroma_h;
  from_.width_px = rounded_up(frame.width, from_.chroma_shift_x);
  from_.height_px = rounded_up(frame.height, from_.chroma_shift_y);
  const bool limited = rgb || grey ? frame.color_range == AVCOL_RANGE_MPEG : !is_full_range(frame);
  from_.range = limited ? CodeRange::Limited : CodeRange::Full;
  from_.chroma_site = chroma_site_of(frame);
  if (from_.colors == PictureColors::Yuv) from_.tags.matrix = matrix_of(frame, codec);
  return {};
}

int DecodedCodes::bits() const {
  return from_.colors == PictureColors::Yuv ? std::max(10, from_.bits) : from_.bits;
}

const char* DecodedCodes::format_name() const { return av_get_pix_fmt_name(pixel_format_); }

bool DecodedCodes::is_like_first(const AVFrame& frame) const {
  return frame.format == pixel_format_ && rounded_up(frame.width, from_.chroma_shift_x) == from_.width_px &&
         rounded_up(frame.height, from_.chroma_shift_y) == from_.height_px;
}

// To RGB or grey of the full range.
Result<void> DecodedCodes::open_converter() {
  PictureFormat to = from_;
  to.bits = bits(), to.range = CodeRange::Full, to.chroma_shift_x = to.chroma_shift_y = 0;
  to.colors = from_.colors == PictureColors::Grey ? PictureColors::Grey : PictureColors::Rgb;
  to.tags = {};
  converted_ = Image<std::uint16_t>(to.planes(), unpacked_.rows(), unpacked_.cols());
  auto converter = PictureConverter::create(from_, to);
  if (!converter)
    return Error{ErrorCode::Unsupported,
                 fmt::format("has colours that cannot become RGB: {}", converter.error().message)};
  converter_.emplace(std::move(converter).value());
  return {};
}

// Into planes of words, whatever the order of bytes and components; chroma that reaches beyond the picture is
// there, luma is repeated.
void DecodedCodes::unpack(const AVFrame& frame) {
  const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(pixel_format_);
  const std::uint8_t* data[4] = {frame.data[0], frame.data[1], frame.data[2], frame.data[3]};
  for (int c = 0; c < from_.planes(); ++c) {
    const bool chroma = c > 0 && from_.colors == PictureColors::Yuv;
    const int cols = chroma ? AV_CEIL_RSHIFT(frame.width, from_.chroma_shift_x) : frame.width;
    const int rows = chroma ? AV_CEIL_RSHIFT(frame.height, from_.chroma_shift_y) : frame.height;
    for (int y = 0; y < rows; ++y) {
      std::uint16_t* const row = unpacked_.row(c, y);
      av_read_image_line2(row, data, frame.linesize, &format, 0, y, c, cols, 0, sizeof(std::uint16_t));
      if (!chroma) std::fill(row + cols, row + from_.width_px, row[cols - 1]);
    }
    for (int y = rows; !chroma && y < from_.height_px; ++y)
      std::copy_n(unpacked_.row(c, rows - 1), unpacked_.cols(), unpacked_.row(c, y));
  }
}

Result<void> DecodedCodes::take(const AVFrame& frame, Orientation orientation, Image<std::uint16_t>& codes) {
  unpack(frame);
  if (converter_) TRY(converter_->convert(planes_of(unpacked_), planes_of(converted_)));
  const Image<std::uint16_t>& result = converter_ ? converted_ : unpacked_;
  reshape_upright(from_.planes(), frame.height, frame.width, orientation, codes);
  for (int c = 0; c < codes.channels(); ++c)
    place_upright({result.plane(c), result.cols(), frame.height, frame.width}, orientation, codes.plane(c));
  return {};
}

}  // namespace hdrcam
