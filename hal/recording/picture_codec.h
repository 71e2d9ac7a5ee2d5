// Pictures of codes to packets and back, without loss, each packet by itself (docs/recording.md): FFmpeg's
// variant of Huffyuv, or FFV1 version 3 (RFC 9043) with checksums of its slices. The bytes do not depend on
// the number of threads. Thread-bound.
#pragma once

#include <cstdint>
#include <span>

#include "hal/core/frame.h"
#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/recording/libav.h"
#include "hal/recording/recording.h"

namespace hdrcam {

// Checks that a recording can hold the size and bit depth. Errors: Invalid.
Result<void> check_recordable(const CameraFacts& camera);

// What the head of a file states of its pictures and no checksum of the codec's own covers, for the one over
// the camera facts. Empty for FFV1.
std::span<const std::uint8_t> unsealed_head(const AVCodecParameters& stream);

class PictureEncoder {
 public:
  // camera must be recordable.
  static Result<PictureEncoder> open(const CameraFacts& camera, RecordingCodec codec);
  // codes: [channels(layout), rows, cols]. The packet stays valid until the next call. Errors: SizeChanged,
  // Invalid.
  Result<AVPacket*> encode(const Image<std::uint16_t>& codes);
  const AVCodecContext* context() const { return context_.get(); }
  RecordingCodec codec() const { return codec_; }

 private:
  RecordingCodec codec_ = RecordingCodec::Huffyuv;
  int bits_ = 8, channels_ = 1;
  libav::CodecContext context_;
  libav::Frame frame_;
  libav::Packet packet_;
};

class PictureDecoder {
 public:
  // stream: the video track. Errors: Corrupt where it does not match the camera facts or is of no codec of a
  // recording.
  static Result<PictureDecoder> open(const CameraFacts& camera, const AVCodecParameters& stream);
  RecordingCodec codec() const { return codec_; }
  // Errors: Corrupt.
  Result<void> decode(const AVPacket& packet, Image<std::uint16_t>& codes);

 private:
  RecordingCodec codec_ = RecordingCodec::Huffyuv;
  int channels_ = 1;
  AVPixelFormat format_ = AV_PIX_FMT_NONE;
  libav::CodecContext context_;
  libav::Frame frame_;
};

}  // namespace hdrcam
