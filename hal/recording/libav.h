// Ownership and errors of the FFmpeg libraries, for the files of this folder that call them. Their log is
// silenced; failures are returned as an Error.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <memory>
#include <string>

#include "hal/core/result.h"

namespace hdrcam::libav {

struct Free {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
using CodecContext = std::unique_ptr<AVCodecContext, Free>;
using Frame = std::unique_ptr<AVFrame, Free>;
using Packet = std::unique_ptr<AVPacket, Free>;

// The library's message for a negative return code.
inline std::string words(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

// Silences the libraries; idempotent, thread-safe.
inline void be_quiet() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace hdrcam::libav
