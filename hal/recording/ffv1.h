// FFV1 version 3, intra frames only, slice checksums on: pictures of codes to packets and back, without loss
// (docs/recording.md, RFC 9043). The bytes do not depend on the number of threads. Thread-bound.
#pragma once

#include <cstdint>

#include "hal/core/frame.h"
#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/recording/libav.h"

namespace hdrcam {

// Checks that a recording can hold the size and bit depth. Errors: Invalid.
Result<void> check_recordable(const CameraFacts& camera);

class Ffv1Encoder {
 public:
  // camera must be recordable.
  static Result<Ffv1Encoder> open(const CameraFacts& camera);
  // codes: [channels(layout), rows, cols]. The packet stays valid until the next call. Errors: SizeChanged,
  // Invalid.
  Result<AVPacket*> encode(const Image<std::uint16_t>& codes);
  const AVCodecContext* context() const { return context_.get(); }

 private:
  int bits_ = 8, channels_ = 1;
  libav::CodecContext context_;
  libav::Frame frame_;
  libav::Packet packet_;
};

class Ffv1Decoder {
 public:
  // stream: the video track. Errors: Corrupt where it does not match the camera facts.
  static Result<Ffv1Decoder> open(const CameraFacts& camera, const AVCodecParameters& stream);
  // Errors: Corrupt.
  Result<void> decode(const AVPacket& packet, Image<std::uint16_t>& codes);

 private:
  int channels_ = 1;
  AVPixelFormat format_ = AV_PIX_FMT_NONE;
  libav::CodecContext context_;
  libav::Frame frame_;
};

}  // namespace hdrcam
