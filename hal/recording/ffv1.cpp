#include "hal/recording/ffv1.h"
#include "hal/recording/recording.h"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <array>
#include <cmath>

namespace hdrcam {
namespace {

// The narrowest format of the encoder that holds `bits`.
AVPixelFormat pixel_format(PixelLayout layout, int bits) {
  if (layout == PixelLayout::Rgb) {
    if (bits <= 8) return AV_PIX_FMT_0RGB32;  // the encoder has no planar RGB of 8 bits
    if (bits <= 9) return AV_PIX_FMT_GBRP9;
    if (bits <= 10) return AV_PIX_FMT_GBRP10;
    if (bits <= 12) return AV_PIX_FMT_GBRP12;
    return bits <= 14 ? AV_PIX_FMT_GBRP14 : AV_PIX_FMT_GBRP16;
  }
  if (bits <= 8) return AV_PIX_FMT_GRAY8;
  if (bits <= 9) return AV_PIX_FMT_GRAY9;
  if (bits <= 10) return AV_PIX_FMT_GRAY10;
  return bits <= 12 ? AV_PIX_FMT_GRAY12 : AV_PIX_FMT_GRAY16;
}

constexpr std::array<int, 3> kPlaneOfRgb = {2, 0, 1};  // the planes of GBRP are green, blue, red

// Where the samples of one row and channel are within a frame. 0RGB32 is a native 32-bit word, red in
// bits 16..23.
template <class Byte>
Byte* row_of(Byte* const* planes, const int* strides, int plane, int y) {
  return planes[plane] + static_cast<std::ptrdiff_t>(y) * strides[plane];
}

void pack(const Image<std::uint16_t>& codes, AVFrame& frame) {
  const int rows = codes.rows(), cols = codes.cols();
  for (int y = 0; y < rows; ++y) {
    if (frame.format == AV_PIX_FMT_0RGB32) {
      const auto *r = codes.row(0, y), *g = codes.row(1, y), *b = codes.row(2, y);
      auto* words = reinterpret_cast<std::uint32_t*>(row_of(frame.data, frame.linesize, 0, y));
      for (int x = 0; x < cols; ++x)
        words[x] = (std::uint32_t{r[x]} << 16) | (std::uint32_t{g[x]} << 8) | b[x];
    } else if (frame.format == AV_PIX_FMT_GRAY8) {
      auto* bytes = row_of(frame.data, frame.linesize, 0, y);
      std::transform(codes.row(0, y), codes.row(0, y) + cols, bytes,
                     [](std::uint16_t code) { return static_cast<std::uint8_t>(code); });
    } else {
      for (int c = 0; c < codes.channels(); ++c) {
        const int plane = codes.channels() == 3 ? kPlaneOfRgb[static_cast<std::size_t>(c)] : 0;
        auto* samples = reinterpret_cast<std::uint16_t*>(row_of(frame.data, frame.linesize, plane, y));
        std::copy_n(codes.row(c, y), cols, samples);
      }
    }
  }
}

void unpack(const AVFrame& frame, Image<std::uint16_t>& codes) {
  const int rows = codes.rows(), cols = codes.cols();
  for (int y = 0; y < rows; ++y) {
    if (frame.format == AV_PIX_FMT_0RGB32) {
      const auto* words = reinterpret_cast<const std::uint32_t*>(row_of(frame.data, frame.linesize, 0, y));
      for (int c = 0; c < 3; ++c) {
        auto* row = codes.row(c, y);
        const int shift = 16 - 8 * c;
        for (int x = 0; x < cols; ++x) row[x] = static_cast<std::uint16_t>((words[x] >> shift) & 0xffu);
      }
    } else if (frame.format == AV_PIX_FMT_GRAY8) {
      std::copy_n(row_of(frame.data, frame.linesize, 0, y), cols, codes.row(0, y));
    } else {
      for (int c = 0; c < codes.channels(); ++c) {
        const int plane = codes.channels() == 3 ? kPlaneOfRgb[static_cast<std::size_t>(c)] : 0;
        std::copy_n(reinterpret_cast<const std::uint16_t*>(row_of(frame.data, frame.linesize, plane, y)),
                    cols, codes.row(c, y));
      }
    }
  }
}

// Whether every slice matches its checksum (RFC 9043, section 4.9): the library's decoder silently fills a
// damaged slice from the previous picture.
bool slices_are_whole(const AVPacket& packet) {
  constexpr int kFooterBytes = 8;  // size of the slice, 3 bytes; its state, 1; checksum over all of it, 4
  const AVCRC* table = av_crc_get_table(AV_CRC_32_IEEE);
  for (int end = packet.size; end > 0;) {
    if (end < kFooterBytes) return false;
    const std::uint8_t* footer = packet.data + end - kFooterBytes;
    const int size = (footer[0] << 16 | footer[1] << 8 | footer[2]) + kFooterBytes;
    if (size > end) return false;
    end -= size;
    if (av_crc(table, 0, packet.data + end, static_cast<std::size_t>(size)) != 0) return false;
  }
  return true;
}

Error corrupt(const char* what, int code) {
  return {ErrorCode::Corrupt, fmt::format("{}: {}", what, libav::words(code))};
}

}  // namespace

Result<void> check_recordable(const CameraFacts& camera) {
  const auto fits = [](int side_px) { return side_px >= kMinSidePx && side_px <= kMaxSidePx; };
  if (!fits(camera.width) || !fits(camera.height))
    return Error{ErrorCode::Invalid,
                 fmt::format("a picture of {}x{} cannot be recorded; each side is {} to {} pixels",
                             camera.width, camera.height, kMinSidePx, kMaxSidePx)};
  if (camera.bits < 8 || camera.bits > 16)
    return Error{ErrorCode::Invalid,
                 fmt::format("codes of {} bits cannot be recorded; 8 to 16 can", camera.bits)};
  if (!(camera.framerate_hz > 0) || !std::isfinite(camera.framerate_hz))
    return Error{ErrorCode::Invalid,
                 fmt::format("a frame rate of {} Hz cannot be recorded; it must be greater than 0",
                             camera.framerate_hz)};
  return {};
}

Result<Ffv1Encoder> Ffv1Encoder::open(const CameraFacts& camera) {
  libav::be_quiet();
  Ffv1Encoder encoder;
  encoder.bits_ = camera.bits;
  encoder.channels_ = channels(camera.layout);
  const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_FFV1);
  if (codec == nullptr)
    return Error{ErrorCode::Unsupported, "the FFmpeg libraries of this machine have no FFV1 encoder"};
  encoder.context_.reset(avcodec_alloc_context3(codec));
  encoder.frame_.reset(av_frame_alloc());
  encoder.packet_.reset(av_packet_alloc());
  CHECK(encoder.context_ && encoder.frame_ && encoder.packet_);
  AVCodecContext& context = *encoder.context_;
  context.width = camera.width;
  context.height = camera.height;
  context.pix_fmt = pixel_format(camera.layout, camera.bits);
  context.time_base = {1, 1000};
  context.gop_size = 1;
  context.level = 3;
  context.flags |= AV_CODEC_FLAG_BITEXACT;
  context.thread_count = 0;
  context.thread_type = FF_THREAD_SLICE;
  context.slices = std::min(camera.width, camera.height) < 64 ? 1 : 4;
  av_opt_set_int(context.priv_data, "slicecrc", 1, 0);
  if (const int code = avcodec_open2(&context, codec, nullptr); code < 0)
    return Error{ErrorCode::Invalid, fmt::format("FFV1 cannot hold {}x{} at {} bits: {}", camera.width,
                                                 camera.height, camera.bits, libav::words(code))};
  encoder.frame_->format = context.pix_fmt;
  encoder.frame_->width = camera.width;
  encoder.frame_->height = camera.height;
  if (const int code = av_frame_get_buffer(encoder.frame_.get(), 0); code < 0)
    return Error{ErrorCode::Io, fmt::format("no memory for a frame of {}x{}", camera.width, camera.height)};
  return encoder;
}

Result<AVPacket*> Ffv1Encoder::encode(const Image<std::uint16_t>& codes) {
  if (codes.channels() != channels_ || codes.rows() != context_->height || codes.cols() != context_->width)
    return Error{ErrorCode::SizeChanged,
                 fmt::format("a frame of {}x{} with {} channel(s) does not fit a recording of {}x{} with {}",
                             codes.cols(), codes.rows(), codes.channels(), context_->width, context_->height,
                             channels_)};
  std::uint32_t used = 0;
  for (const std::uint16_t code : codes.samples()) used |= code;
  if ((used >> bits_) != 0)
    return Error{
        ErrorCode::Invalid,
        fmt::format("a frame holds codes of more than {} bits; the camera facts state {}", bits_, bits_)};
  if (av_frame_make_writable(frame_.get()) < 0) return Error{ErrorCode::Io, "no memory for a frame"};
  pack(codes, *frame_);
  av_packet_unref(packet_.get());
  int code = avcodec_send_frame(context_.get(), frame_.get());
  if (code >= 0) code = avcodec_receive_packet(context_.get(), packet_.get());
  if (code < 0)
    return Error{ErrorCode::Io, fmt::format("FFV1 could not encode a frame: {}", libav::words(code))};
  return packet_.get();
}

Result<Ffv1Decoder> Ffv1Decoder::open(const CameraFacts& camera, const AVCodecParameters& stream) {
  libav::be_quiet();
  Ffv1Decoder decoder;
  decoder.channels_ = channels(camera.layout);
  const AVCodec* codec = avcodec_find_decoder(AV_CODEC_ID_FFV1);
  if (codec == nullptr)
    return Error{ErrorCode::Unsupported, "the FFmpeg libraries of this machine have no FFV1 decoder"};
  decoder.context_.reset(avcodec_alloc_context3(codec));
  decoder.frame_.reset(av_frame_alloc());
  CHECK(decoder.context_ && decoder.frame_);
  AVCodecContext& context = *decoder.context_;
  if (const int code = avcodec_parameters_to_context(&context, &stream); code < 0)
    return corrupt("the video track cannot be read", code);
  context.width = camera.width;  // the checked facts, not the unchecked track header
  context.height = camera.height;
  context.pix_fmt = decoder.format_ = pixel_format(camera.layout, camera.bits);
  context.thread_count = 0;
  context.thread_type = FF_THREAD_SLICE;
  if (const int code = avcodec_open2(&context, codec, nullptr); code < 0)
    return corrupt("the video track cannot be decoded", code);
  return decoder;
}

Result<void> Ffv1Decoder::decode(const AVPacket& packet, Image<std::uint16_t>& codes) {
  if (!slices_are_whole(packet))
    return Error{ErrorCode::Corrupt, "the pixels of a frame do not match their checksum"};
  int code = avcodec_send_packet(context_.get(), &packet);
  if (code >= 0) code = avcodec_receive_frame(context_.get(), frame_.get());
  if (code < 0) return corrupt("the pixels of a frame cannot be decoded", code);
  if (frame_->width != context_->width || frame_->height != context_->height || frame_->format != format_)
    return Error{ErrorCode::Corrupt,
                 "the pixels of a frame are not of the size and depth that the camera facts name"};
  codes.reshape(channels_, frame_->height, frame_->width);
  unpack(*frame_, codes);
  return {};
}

}  // namespace hdrcam
