// How a video of the HDR frames is made, whatever it is written to (hdr_video.h, half_pipe.h). Plain values.
#pragma once

namespace hdrcam {

enum class VideoTransfer {
  Pq,   // HDR10: absolute luminance, SMPTE ST 2084
  Hlg,  // hybrid log-gamma, Rec. ITU-R BT.2100: for broadcast, and watchable on displays without HDR
  Sdr,  // tone-mapped with one curve for the clip (render/tone_curve.h), BT.709
};
enum class CodecChoice { Suitable, Hevc, Av1, H264 };  // Suitable: H.264 for SDR, else HEVC
enum class PipeFormat { Nut, Y4m, Half };

struct VideoOptions {
  VideoTransfer transfer = VideoTransfer::Pq;
  CodecChoice codec = CodecChoice::Suitable;
  double white_nits = 203;  // of radiance 1: HDR reference white, Report ITU-R BT.2408
  double peak_nits = 1000;  // brighter light is taken into the range below it
  int crf = 16;             // constant rate factor: less is better and larger
  PipeFormat pipe = PipeFormat::Nut;
};

}  // namespace hdrcam
