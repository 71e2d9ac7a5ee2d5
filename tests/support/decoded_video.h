// A video as a player sees it, by the FFmpeg libraries alone: tags, side data, and each frame's codes and
// time.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/mastering_display_metadata.h>
#include <libavutil/pixdesc.h>
}

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/image.h"
#include "hal/recording/libav.h"

namespace hdrcam::test {

struct DecodedFrame {
  double time_s = 0;
  Image<std::uint16_t> luma, cb, cr;  // [1, rows, cols], codes
  std::optional<AVMasteringDisplayMetadata> mastering;
  std::optional<AVContentLightMetadata> light;
};

struct DecodedVideo {
  std::string codec, pixel_format, container;
  int width = 0, height = 0;
  std::string primaries, transfer, matrix, range, siting;
  std::optional<AVMasteringDisplayMetadata> mastering;  // of the container
  std::optional<AVContentLightMetadata> light;
  std::vector<DecodedFrame> frames;
};

inline Image<std::uint16_t> plane_of(const AVFrame& frame, int plane) {
  const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  const int cols = plane == 0 ? frame.width : AV_CEIL_RSHIFT(frame.width, format.log2_chroma_w);
  const int rows = plane == 0 ? frame.height : AV_CEIL_RSHIFT(frame.height, format.log2_chroma_h);
  Image<std::uint16_t> codes(1, rows, cols);
  for (int y = 0; y < rows; ++y) {
    const std::uint8_t* const row = frame.data[plane] + y * frame.linesize[plane];
    for (int x = 0; x < cols; ++x)
      codes.at(0, y, x) = format.comp[0].depth > 8 ? reinterpret_cast<const std::uint16_t*>(row)[x] : row[x];
  }
  return codes;
}

template <class T>
std::optional<T> side_data(const AVFrame& frame, AVFrameSideDataType type) {
  const AVFrameSideData* const found = av_frame_get_side_data(&frame, type);
  return found == nullptr ? std::nullopt : std::optional(*reinterpret_cast<const T*>(found->data));
}
template <class T>
std::optional<T> side_data(const AVStream& stream, AVPacketSideDataType type) {
#if HDRCAM_LIBAV_CODED_SIDE_DATA
  const AVCodecParameters& codec = *stream.codecpar;
  const AVPacketSideData* const side =
      av_packet_side_data_get(codec.coded_side_data, codec.nb_coded_side_data, type);
  const std::uint8_t* const found = side == nullptr ? nullptr : side->data;
#else
  const std::uint8_t* const found = av_stream_get_side_data(&stream, type, nullptr);
#endif
  return found == nullptr ? std::nullopt : std::optional(*reinterpret_cast<const T*>(found));
}

// Everything that can be decoded; an empty video where the file is none.
inline DecodedVideo decoded_video(const std::string& path) {
  libav::be_quiet();
  DecodedVideo video;
  AVFormatContext* opened = nullptr;
  if (avformat_open_input(&opened, path.c_str(), nullptr, nullptr) < 0) return video;
  const auto close = [](AVFormatContext* demuxer) { avformat_close_input(&demuxer); };
  const std::unique_ptr<AVFormatContext, decltype(close)> demuxer(opened, close);
  if (avformat_find_stream_info(opened, nullptr) < 0 || opened->nb_streams == 0) return video;
  const AVStream& stream = *opened->streams[0];
  const libav::CodecContext decoder(avcodec_alloc_context3(avcodec_find_decoder(stream.codecpar->codec_id)));
  avcodec_parameters_to_context(decoder.get(), stream.codecpar);
  if (avcodec_open2(decoder.get(), nullptr, nullptr) < 0) return video;

  const auto text = [](const char* name) { return std::string(name == nullptr ? "unknown" : name); };
  video.container = opened->iformat->name;
  video.codec = avcodec_get_name(stream.codecpar->codec_id);
  video.width = stream.codecpar->width, video.height = stream.codecpar->height;
  video.mastering = side_data<AVMasteringDisplayMetadata>(stream, AV_PKT_DATA_MASTERING_DISPLAY_METADATA);
  video.light = side_data<AVContentLightMetadata>(stream, AV_PKT_DATA_CONTENT_LIGHT_LEVEL);

  const libav::Packet packet(av_packet_alloc());
  const libav::Frame frame(av_frame_alloc());
  const auto take = [&] {
    while (avcodec_receive_frame(decoder.get(), frame.get()) >= 0) {
      video.pixel_format = text(av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame->format)));
      video.primaries = text(av_color_primaries_name(frame->color_primaries));
      video.transfer = text(av_color_transfer_name(frame->color_trc));
      video.matrix = text(av_color_space_name(frame->colorspace));
      video.range = text(av_color_range_name(frame->color_range));
      video.siting = text(av_chroma_location_name(frame->chroma_location));
      video.frames.push_back(
          {static_cast<double>(frame->best_effort_timestamp) * av_q2d(stream.time_base), plane_of(*frame, 0),
           plane_of(*frame, 1), plane_of(*frame, 2),
           side_data<AVMasteringDisplayMetadata>(*frame, AV_FRAME_DATA_MASTERING_DISPLAY_METADATA),
           side_data<AVContentLightMetadata>(*frame, AV_FRAME_DATA_CONTENT_LIGHT_LEVEL)});
    }
  };
  while (av_read_frame(opened, packet.get()) >= 0) {
    if (packet->stream_index == 0 && avcodec_send_packet(decoder.get(), packet.get()) >= 0) take();
    av_packet_unref(packet.get());
  }
  avcodec_send_packet(decoder.get(), nullptr);
  take();
  return video;
}

}  // namespace hdrcam::test
