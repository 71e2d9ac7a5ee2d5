#include "hal/video/picture_converter.h"

#include <fmt/format.h>
#include <zimg.h>

#include <new>

namespace hdrcam {
namespace {

constexpr std::align_val_t kAlignment{PictureConverter::kAlignment_bytes};

Error zimg_error(ErrorCode code, const char* what) {
  char words[512] = {};
  zimg_get_last_error(words, sizeof words);
  zimg_clear_last_error();
  return {code, fmt::format("cannot {}: zimg says '{}'", what, words)};
}

zimg_chroma_location_e location_of(ChromaSite site) {
  switch (site) {
    case ChromaSite::Left:
      return ZIMG_CHROMA_LEFT;
    case ChromaSite::Center:
      return ZIMG_CHROMA_CENTER;
    case ChromaSite::TopLeft:
      return ZIMG_CHROMA_TOP_LEFT;
  }
  return ZIMG_CHROMA_LEFT;
}

zimg_image_format format_of(const PictureFormat& picture) {
  zimg_image_format format;
  zimg_image_format_default(&format, ZIMG_API_VERSION);
  format.width = static_cast<unsigned>(picture.width_px);
  format.height = static_cast<unsigned>(picture.height_px);
  const bool byte = picture.bits == 8 && picture.store == SampleStore::Narrowest;
  format.pixel_type = picture.bits == 0 ? ZIMG_PIXEL_FLOAT : byte ? ZIMG_PIXEL_BYTE : ZIMG_PIXEL_WORD;
  if (picture.bits > 0) format.depth = static_cast<unsigned>(picture.bits);
  format.subsample_w = static_cast<unsigned>(picture.chroma_shift_x);
  format.subsample_h = static_cast<unsigned>(picture.chroma_shift_y);
  format.color_family = picture.colors == PictureColors::Rgb   ? ZIMG_COLOR_RGB
                        : picture.colors == PictureColors::Yuv ? ZIMG_COLOR_YUV
                                                               : ZIMG_COLOR_GREY;
  format.matrix_coefficients = static_cast<zimg_matrix_coefficients_e>(
      picture.colors == PictureColors::Rgb ? h273::kMatrixRgb : picture.tags.matrix);
  format.transfer_characteristics = static_cast<zimg_transfer_characteristics_e>(picture.tags.transfer);
  format.color_primaries = static_cast<zimg_color_primaries_e>(picture.tags.primaries);
  format.pixel_range = picture.range == CodeRange::Full ? ZIMG_RANGE_FULL : ZIMG_RANGE_LIMITED;
  format.chroma_location = location_of(picture.chroma_site);
  return format;
}

}  // namespace

void PictureConverter::FreeGraph::operator()(void* graph) const {
  zimg_filter_graph_free(static_cast<zimg_filter_graph*>(graph));
}

void PictureConverter::FreeAligned::operator()(std::byte* bytes) const {
  ::operator delete[](bytes, kAlignment);
}

Result<PictureConverter> PictureConverter::create(const PictureFormat& from, const PictureFormat& to) {
  const zimg_image_format source = format_of(from), target = format_of(to);
  zimg_graph_builder_params params;
  zimg_graph_builder_params_default(&params, ZIMG_API_VERSION);
  params.resample_filter = params.resample_filter_uv = ZIMG_RESIZE_BICUBIC;
  params.nominal_peak_luminance = 1;  // a linear 1 is 1 cd/m2
  PictureConverter converter;
  converter.planes_from_ = from.planes(), converter.planes_to_ = to.planes();
  converter.graph_.reset(zimg_filter_graph_build(&source, &target, &params));
  if (!converter.graph_) return zimg_error(ErrorCode::Unsupported, "convert the pictures of this video");
  std::size_t bytes = 0;
  if (zimg_filter_graph_get_tmp_size(static_cast<zimg_filter_graph*>(converter.graph_.get()), &bytes) !=
      ZIMG_ERROR_SUCCESS)
    return zimg_error(ErrorCode::Io, "convert a picture");
  converter.work_.reset(static_cast<std::byte*>(::operator new[](bytes, kAlignment)));
  return converter;
}

Result<void> PictureConverter::convert(const ConstPicturePlanes& from, const PicturePlanes& to) {
  zimg_image_buffer_const source{};
  zimg_image_buffer target{};
  source.version = target.version = ZIMG_API_VERSION;
  for (std::size_t i = 0; i < static_cast<std::size_t>(planes_from_); ++i) {
    source.plane[i].data = from.data[i];
    source.plane[i].stride = from.stride_bytes[i];
    source.plane[i].mask = ZIMG_BUFFER_MAX;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(planes_to_); ++i) {
    target.plane[i].data = to.data[i];
    target.plane[i].stride = to.stride_bytes[i];
    target.plane[i].mask = ZIMG_BUFFER_MAX;
  }
  if (zimg_filter_graph_process(static_cast<zimg_filter_graph*>(graph_.get()), &source, &target, work_.get(),
                                nullptr, nullptr, nullptr, nullptr) != ZIMG_ERROR_SUCCESS)
    return zimg_error(ErrorCode::Io, "convert a picture");
  return {};
}

}  // namespace hdrcam
