#include "hal/recording/picture_codec.h"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>

#include "hal/core/counted.h"
#include "hal/core/sound_facts.h"

namespace hdrcam {
namespace {

AVCodecID id_of(RecordingCodec codec) {
  return codec == RecordingCodec::Ffv1 ? AV_CODEC_ID_FFV1 : AV_CODEC_ID_FFVHUFF;
}

const char* known_as(RecordingCodec codec) { return codec == RecordingCodec::Ffv1 ? "FFV1" : "Huffyuv"; }

std::optional<RecordingCodec> codec_of(AVCodecID id) {
  for (const RecordingCodec codec : {RecordingCodec::Huffyuv, RecordingCodec::Ffv1})
    if (id_of(codec) == id) return codec;
  return std::nullopt;
}

// The narrowest format of the encoder that holds `bits`.
AVPixelFormat pixel_format(RecordingCodec codec, PixelLayout layout, int bits) {
  if (layout == PixelLayout::Rgb) {
    // FFV1 has no planar RGB of 8 bits
    if (bits <= 8) return codec == RecordingCodec::Ffv1 ? AV_PIX_FMT_0RGB32 : AV_PIX_FMT_GBRP;
    if (bits <= 9) return AV_PIX_FMT_GBRP9;
    if (bits <= 10) return AV_PIX_FMT_GBRP10;
    if (bits <= 12) return AV_PIX_FMT_GBRP12;
    return bits <= 14 ? AV_PIX_FMT_GBRP14 : AV_PIX_FMT_GBRP16;
  }
  if (bits <= 8) return AV_PIX_FMT_GRAY8;
  if (codec == RecordingCodec::Huffyuv) return AV_PIX_FMT_GRAY16;
  if (bits <= 9) return AV_PIX_FMT_GRAY9;
  if (bits <= 10) return AV_PIX_FMT_GRAY10;
  return bits <= 12 ? AV_PIX_FMT_GRAY12 : AV_PIX_FMT_GRAY16;
}

constexpr std::array<int, 3> kPlaneOfRgb = {2, 0, 1};  // the planes of GBRP are green, blue, red

// Where the samples of one row and channel are within a frame. 0RGB32 is a native 32-bit word, red in bits
// 16..23.
template <class Byte>
Byte* row_of(Byte* const* planes, const int* strides, int plane, int y) {
  return planes[plane] + static_cast<std::ptrdiff_t>(y) * strides[plane];
}

bool is_of_bytes(const AVFrame& frame) {
  return frame.format == AV_PIX_FMT_GRAY8 || frame.format == AV_PIX_FMT_GBRP;
}

// Of a format that is not 0RGB32.
int plane_of(const Image<std::uint16_t>& codes, int channel) {
  return codes.channels() == 3 ? kPlaneOfRgb[static_cast<std::size_t>(channel)] : 0;
}

void pack(const Image<std::uint16_t>& codes, AVFrame& frame) {
  const int rows = codes.rows(), cols = codes.cols();
  for (int y = 0; y < rows; ++y) {
    if (frame.format == AV_PIX_FMT_0RGB32) {
      const auto *r = codes.row(0, y), *g = codes.row(1, y), *b = codes.row(2, y);
      auto* words = reinterpret_cast<std::uint32_t*>(row_of(frame.data, frame.linesize, 0, y));
      for (int x = 0; x < cols; ++x)
        words[x] = (std::uint32_t{r[x]} << 16) | (std::uint32_t{g[x]} << 8) | b[x];
      continue;
    }
    for (int c = 0; c < codes.channels(); ++c) {
      auto* bytes = row_of(frame.data, frame.linesize, plane_of(codes, c), y);
      if (is_of_bytes(frame))
        std::transform(codes.row(c, y), codes.row(c, y) + cols, bytes,
                       [](std::uint16_t code) { return static_cast<std::uint8_t>(code); });
      else
        std::copy_n(codes.row(c, y), cols, reinterpret_cast<std::uint16_t*>(bytes));
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
      continue;
    }
    for (int c = 0; c < codes.channels(); ++c) {
      const auto* bytes = row_of(frame.data, frame.linesize, plane_of(codes, c), y);
      if (is_of_bytes(frame))
        std::copy_n(bytes, cols, codes.row(c, y));
      else
        std::copy_n(reinterpret_cast<const std::uint16_t*>(bytes), cols, codes.row(c, y));
    }
  }
}

// Whether every slice of FFV1 matches its checksum (RFC 9043, section 4.9): the library's decoder silently
// fills a damaged slice from the previous picture.
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

// Of FFV1. One for small pictures, as far as FFmpeg lets them have one; 0: four, more for those that are too
// large for four. Slices of a single line do not read back as they were.
int slices_of(const CameraFacts& camera) {
  constexpr int kSmall_px = 64, kMostCols = 352, kMostRows = 288, kLeastOfTwo_px = 4;
  const int shorter = std::min(camera.width, camera.height);
  const bool may_be_one = camera.width <= kMostCols && camera.height <= kMostRows;
  return shorter < kLeastOfTwo_px || (shorter < kSmall_px && may_be_one) ? 1 : 0;
}

// What the encoder is told beside the size. Huffyuv's tables of codes are made for each picture up to 8 bits,
// which takes a millisecond and saves a twentieth; of more bits they take six and stay as they are.
void configure(RecordingCodec codec, const CameraFacts& camera, AVCodecContext& context) {
  if (codec == RecordingCodec::Huffyuv) {
    context.thread_count = 1;
    av_opt_set_int(context.priv_data, "context", camera.bits <= 8 ? 1 : 0, 0);
    return;
  }
  context.gop_size = 1;
  context.level = 3;
  context.thread_count = 0;
  context.thread_type = FF_THREAD_SLICE;
  context.slices = slices_of(camera);
  av_opt_set_int(context.priv_data, "slicecrc", 1, 0);
}

// FFmpeg's Huffyuv sizes the packet of a picture for the worst case, 12 bytes a pixel, in 31 bits: a larger
// picture would fail in the run, at its first frame.
Result<void> check_packet(RecordingCodec codec, const CameraFacts& camera) {
  constexpr std::int64_t kBytesPerPixel = 12;
  constexpr std::int64_t kMost_px =
      (INT_MAX - AV_INPUT_BUFFER_MIN_SIZE - AV_INPUT_BUFFER_PADDING_SIZE) / kBytesPerPixel;
  if (codec != RecordingCodec::Huffyuv || std::int64_t{camera.width} * camera.height <= kMost_px) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("Huffyuv holds pictures of up to {} megapixels, not {}x{}; choose "
                           "--record-codec ffv1, or a smaller size",
                           kMost_px / 1'000'000, camera.width, camera.height)};
}

Error corrupt(const char* what, int code) {
  return {ErrorCode::Corrupt, fmt::format("{}: {}", what, libav::words(code))};
}

}  // namespace

std::span<const std::uint8_t> unsealed_head(const AVCodecParameters& stream) {
  if (stream.codec_id != AV_CODEC_ID_FFVHUFF) return {};  // that of FFV1 is sealed: RFC 9043, section 4.3
  return {stream.extradata, static_cast<std::size_t>(std::max(0, stream.extradata_size))};
}

Result<void> check_recordable(const CameraFacts& camera) {
  if (!is_possible_side(camera.width) || !is_possible_side(camera.height))
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

Result<PictureEncoder> PictureEncoder::open(const CameraFacts& camera, RecordingCodec recording) {
  libav::be_quiet();
  TRY(check_packet(recording, camera));
  PictureEncoder encoder;
  encoder.codec_ = recording;
  encoder.bits_ = camera.bits;
  encoder.channels_ = channels(camera.layout);
  const AVCodec* codec = avcodec_find_encoder(id_of(recording));
  if (codec == nullptr)
    return Error{ErrorCode::Unsupported,
                 fmt::format("the FFmpeg libraries of this machine have no {} encoder", known_as(recording))};
  encoder.context_.reset(libav::allocated(avcodec_alloc_context3(codec)));
  encoder.frame_.reset(libav::allocated(av_frame_alloc()));
  encoder.packet_.reset(libav::allocated(av_packet_alloc()));
  AVCodecContext& context = *encoder.context_;
  context.width = camera.width;
  context.height = camera.height;
  context.pix_fmt = pixel_format(recording, camera.layout, camera.bits);
  context.time_base = {1, 1000};
  context.flags |= AV_CODEC_FLAG_BITEXACT;
  configure(recording, camera, context);
  if (const int code = avcodec_open2(&context, codec, nullptr); code < 0)
    return Error{ErrorCode::Invalid,
                 fmt::format("{} cannot hold {}x{} at {} bits: {}", known_as(recording), camera.width,
                             camera.height, camera.bits, libav::words(code))};
  encoder.frame_->format = context.pix_fmt;
  encoder.frame_->width = camera.width;
  encoder.frame_->height = camera.height;
  if (const int code = av_frame_get_buffer(encoder.frame_.get(), 0); code < 0)
    return Error{ErrorCode::Io, fmt::format("no memory for a frame of {}x{}", camera.width, camera.height)};
  return encoder;
}

Result<AVPacket*> PictureEncoder::encode(const Image<std::uint16_t>& codes) {
  if (codes.channels() != channels_ || codes.rows() != context_->height || codes.cols() != context_->width)
    return Error{ErrorCode::SizeChanged,
                 fmt::format("a frame of {}x{} with {} does not fit a recording of {}x{} with {}",
                             codes.cols(), codes.rows(), counted(codes.channels(), "channel"),
                             context_->width, context_->height, channels_)};
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
    return Error{ErrorCode::Io, fmt::format("a frame could not be encoded: {}", libav::words(code))};
  return packet_.get();
}

Result<PictureDecoder> PictureDecoder::open(const CameraFacts& camera, const AVCodecParameters& stream) {
  libav::be_quiet();
  const auto known = codec_of(stream.codec_id);
  if (!known) return Error{ErrorCode::Corrupt, "its pixels are of a codec that no recording has"};
  PictureDecoder decoder;
  decoder.codec_ = *known;
  decoder.channels_ = channels(camera.layout);
  const AVCodec* codec = avcodec_find_decoder(stream.codec_id);
  if (codec == nullptr)
    return Error{ErrorCode::Unsupported,
                 fmt::format("the FFmpeg libraries of this machine have no {} decoder", known_as(*known))};
  decoder.context_.reset(libav::allocated(avcodec_alloc_context3(codec)));
  decoder.frame_.reset(libav::allocated(av_frame_alloc()));
  AVCodecContext& context = *decoder.context_;
  if (const int code = avcodec_parameters_to_context(&context, &stream); code < 0)
    return corrupt("the video track cannot be read", code);
  context.width = camera.width;  // the checked facts, not the unchecked track header
  context.height = camera.height;
  context.pix_fmt = decoder.format_ = pixel_format(*known, camera.layout, camera.bits);
  if (*known == RecordingCodec::Huffyuv)
    context.bits_per_coded_sample = 24;  // the newest form of the head, whatever the track says of them
  context.thread_count = 0;
  context.thread_type = FF_THREAD_SLICE;
  if (const int code = avcodec_open2(&context, codec, nullptr); code < 0)
    return corrupt("the video track cannot be decoded", code);
  return decoder;
}

Result<void> PictureDecoder::decode(const AVPacket& packet, Image<std::uint16_t>& codes) {
  if (codec_ == RecordingCodec::Ffv1 && !slices_are_whole(packet))
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
