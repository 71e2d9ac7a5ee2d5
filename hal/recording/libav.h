// Ownership and errors of the FFmpeg libraries, for the files that call them, here, in hal/video/ and in
// hal/footage/. Their log is silenced; failures are returned as an Error.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>

#include "hal/core/check.h"
#include "hal/core/result.h"

namespace hdrcam::libav {

// What a function of the library allocated; without memory std::bad_alloc, as of new.
template <class T>
T* allocated(T* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

// The return code of a function that fails without memory alone; see allocated().
inline void check_memory(int code) {
  if (code == AVERROR(ENOMEM)) throw std::bad_alloc();
  HDRCAM_CHECK(code >= 0);
}

struct Free {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
using CodecContext = std::unique_ptr<AVCodecContext, Free>;
using Frame = std::unique_ptr<AVFrame, Free>;
using Packet = std::unique_ptr<AVPacket, Free>;

// The library has one type for reading and writing a container, and a function for the end of each.
struct CloseDemuxer {
  void operator()(AVFormatContext* demuxer) const { avformat_close_input(&demuxer); }
};
struct FreeMuxer {
  void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
};
// The stream that they read or write (storage_stream.h) outlives them.
using Demuxer = std::unique_ptr<AVFormatContext, CloseDemuxer>;
using Muxer = std::unique_ptr<AVFormatContext, FreeMuxer>;

// FFmpeg 5 (Debian 12) has other names than 6.1 and later (Ubuntu 24.04, Debian 13).
#if LIBAVFORMAT_VERSION_MAJOR >= 61
using Written = const std::uint8_t;  // what a stream is given to write
#else
using Written = std::uint8_t;
#endif
#ifdef AV_FRAME_FLAG_KEY
inline bool is_key(const AVFrame& frame) { return (frame.flags & AV_FRAME_FLAG_KEY) != 0; }
inline bool is_interlaced(const AVFrame& frame) { return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0; }
#else
inline bool is_key(const AVFrame& frame) { return frame.key_frame != 0; }
inline bool is_interlaced(const AVFrame& frame) { return frame.interlaced_frame != 0; }
#endif

// Whether a stream's side data is with its codec parameters, as from 6.1 on, or with the stream itself.
#define HDRCAM_LIBAV_CODED_SIDE_DATA (LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 16, 100))

// `data`, from av_malloc, belongs to the stream then.
inline void add_side_data(AVStream& stream, AVPacketSideDataType type, void* data, std::size_t size) {
#if HDRCAM_LIBAV_CODED_SIDE_DATA
  AVCodecParameters& codec = *stream.codecpar;
  allocated(av_packet_side_data_add(&codec.coded_side_data, &codec.nb_coded_side_data, type, data, size, 0));
#else
  check_memory(av_stream_add_side_data(&stream, type, static_cast<std::uint8_t*>(data), size));
#endif
}

// Of a stream; nullptr: it has none of that type.
inline const std::uint8_t* side_data(const AVStream& stream, AVPacketSideDataType type) {
#if HDRCAM_LIBAV_CODED_SIDE_DATA
  const AVCodecParameters& codec = *stream.codecpar;
  const AVPacketSideData* const found =
      av_packet_side_data_get(codec.coded_side_data, codec.nb_coded_side_data, type);
  return found != nullptr ? found->data : nullptr;
#else
  return av_stream_get_side_data(&stream, type, nullptr);
#endif
}

// The library's message for a negative return code.
inline std::string words(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

// Silences the libraries; idempotent, thread-safe.
inline void be_quiet() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace hdrcam::libav
