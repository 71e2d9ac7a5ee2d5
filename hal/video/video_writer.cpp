#include "hal/video/video_writer.h"

extern "C" {
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <thread>
#include <utility>

#include "hal/core/file_extension.h"
#include "hal/recording/nominal_rate.h"

namespace hdrcam {
namespace {

constexpr AVRational kMicroseconds = {1, 1'000'000};
constexpr double kFragment_s = 1;  // what a cut costs at most

// FFmpeg divides pictures for x265 into blocks of 64, 32 or 16 pixels, and takes none smaller than a block.
constexpr int kLeastSideOfHevc_px = 16;

// x265 (3.5, AVX) works on its CU tree in rows of 16-pixel blocks and writes behind the end of a row of less
// than four; twice that is safe.
constexpr int kLeastWidthOfTree_px = 128;

const char* muxer_name(VideoContainer container) {
  switch (container) {
    case VideoContainer::Mp4:
      return "mp4";
    case VideoContainer::Mov:
      return "mov";
    case VideoContainer::Matroska:
      return "matroska";
    case VideoContainer::Nut:
      return "nut";
    case VideoContainer::Y4m:
      return "yuv4mpegpipe";
  }
  return "";
}

const char* encoder_name(const VideoFormat& format) {
  switch (format.codec) {
    case VideoCodec::Hevc:
      return "libx265";
    case VideoCodec::Av1:
      return "libaom-av1";
    case VideoCodec::H264:
      return "libx264";
    case VideoCodec::Uncompressed:
      return format.container == VideoContainer::Y4m ? "wrapped_avframe" : "rawvideo";
  }
  return "";
}

AVChromaLocation location_of(ChromaSite site) {
  switch (site) {
    case ChromaSite::Left:
      return AVCHROMA_LOC_LEFT;
    case ChromaSite::Center:
      return AVCHROMA_LOC_CENTER;
    case ChromaSite::TopLeft:
      return AVCHROMA_LOC_TOPLEFT;
  }
  return AVCHROMA_LOC_UNSPECIFIED;
}

// The same in the words of libaom, to which FFmpeg does not pass it on; AV1 has none for the centre.
const char* aom_name(ChromaSite site) {
  switch (site) {
    case ChromaSite::Left:
      return "vertical";
    case ChromaSite::TopLeft:
      return "colocated";
    case ChromaSite::Center:
      break;
  }
  return "unknown";
}

bool is_mp4(VideoContainer container) {
  return container == VideoContainer::Mp4 || container == VideoContainer::Mov;
}

// Before it is known what the stream holds: as much as its display can show.
LightLevel bound_of(const MasteringDisplay& display) {
  const int peak = static_cast<int>(std::ceil(display.peak_nits));
  return {peak, peak};
}

// Fast and good settings, measured in docs/video.md; nothing is predicted from later frames.
void set_codec_options(const VideoFormat& format, AVCodecContext& encoder) {
  const auto set = [&](const char* option, const std::string& value) {
    HDRCAM_CHECK(av_opt_set(encoder.priv_data, option, value.c_str(), 0) >= 0);
  };
  encoder.max_b_frames = 0;
  if (format.codec == VideoCodec::Uncompressed) return;
  set("crf", fmt::format("{}", format.crf));
  if (format.codec == VideoCodec::Av1) {
    set("cpu-used", "8");
    set("lag-in-frames", "0");
    set("row-mt", "1");
    set("aom-params", fmt::format("chroma-sample-position={}", aom_name(format.chroma_site)));
    encoder.thread_count = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 16u));
    return;
  }
  set("preset", "fast");
  if (format.codec != VideoCodec::Hevc) return;
  std::string parameters = "log-level=none:bframes=0:open-gop=0";
  if (format.coded_width_px() < kLeastWidthOfTree_px) parameters += ":cutree=0";
  if (format.mastering) parameters += ':', parameters += x265_parameters(*format.mastering);
  set("x265-params", parameters);
}

}  // namespace

std::optional<VideoContainer> video_container_of(std::string_view path) {
  const std::string extension = lower_extension(path);
  if (extension == ".mp4") return VideoContainer::Mp4;
  if (extension == ".mov") return VideoContainer::Mov;
  if (extension == ".mkv") return VideoContainer::Matroska;
  return std::nullopt;
}

PictureFormat VideoFormat::picture() const {
  return {.width_px = coded_width_px(),
          .height_px = coded_height_px(),
          .bits = bits,
          .colors = PictureColors::Yuv,
          .chroma_shift_x = 1,
          .chroma_shift_y = 1,
          .chroma_site = chroma_site,
          .range = CodeRange::Limited,
          .tags = tags};
}

Result<void> check_picture_size(const VideoFormat& format) {
  const int least_px = format.codec == VideoCodec::Hevc ? kLeastSideOfHevc_px : 1;
  if (format.coded_width_px() >= least_px && format.coded_height_px() >= least_px) return {};
  return Error{ErrorCode::Unsupported,
               fmt::format("{} encodes no pictures smaller than {}x{}, and these are {}x{}; choose another "
                           "--codec",
                           encoder_name(format), least_px, least_px, format.width_px, format.height_px)};
}

Result<std::unique_ptr<VideoWriter>> VideoWriter::create(std::unique_ptr<StorageFile> file,
                                                         StorageStream::Direction direction,
                                                         const VideoFormat& format) {
  TRY(check_picture_size(format));
  libav::be_quiet();
  std::unique_ptr<VideoWriter> writer(new VideoWriter(std::move(file), direction));
  AVFormatContext* muxer = nullptr;
  if (avformat_alloc_output_context2(&muxer, nullptr, muxer_name(format.container), nullptr) < 0)
    return Error{ErrorCode::Unsupported, fmt::format("the FFmpeg libraries of this machine cannot write {}",
                                                     muxer_name(format.container))};
  writer->muxer_.reset(muxer);
  TRY(writer->open_encoder(format));
  TRY(writer->write_header(format));
  return writer;
}

Result<void> VideoWriter::open_encoder(const VideoFormat& format) {
  const AVCodec* codec = avcodec_find_encoder_by_name(encoder_name(format));
  if (codec == nullptr)
    return Error{ErrorCode::Unsupported,
                 fmt::format("the FFmpeg libraries of this machine lack the encoder {}; "
                             "choose another one with --codec",
                             encoder_name(format))};
  encoder_.reset(libav::allocated(avcodec_alloc_context3(codec)));
  AVCodecContext& encoder = *encoder_;
  encoder.width = format.coded_width_px(), encoder.height = format.coded_height_px();
  encoder.pix_fmt = format.bits == 8 ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV420P10;
  const NominalRate rate = nominal_rate(format.framerate_hz);
  encoder.framerate = {rate.numerator, rate.denominator};
  encoder.time_base = av_inv_q(encoder.framerate);  // of the encoder: pictures are numbered
  if (format.codec == VideoCodec::Av1 && encoder.time_base.num > encoder.time_base.den)
    encoder.time_base = {1, 1};  // libaom takes no longer unit
  encoder.gop_size = std::max(1, static_cast<int>(std::lround(format.framerate_hz * kFragment_s)));
  encoder.color_primaries = static_cast<AVColorPrimaries>(format.tags.primaries);
  encoder.color_trc = static_cast<AVColorTransferCharacteristic>(format.tags.transfer);
  encoder.colorspace = static_cast<AVColorSpace>(format.tags.matrix);
  encoder.color_range = AVCOL_RANGE_MPEG;
  encoder.chroma_sample_location = location_of(format.chroma_site);
  encoder.field_order = AV_FIELD_PROGRESSIVE;
  if (muxer_->oformat->flags & AVFMT_GLOBALHEADER) encoder.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  set_codec_options(format, encoder);
  if (const int code = avcodec_open2(&encoder, codec, nullptr); code < 0)
    return Error{ErrorCode::Unsupported,
                 fmt::format("{} cannot encode {}x{} pictures of {} bits: {}; choose another --codec",
                             codec->name, encoder.width, encoder.height, format.bits, libav::words(code))};

  frame_.reset(libav::allocated(av_frame_alloc()));
  packet_.reset(libav::allocated(av_packet_alloc()));
  frame_->width = encoder.width, frame_->height = encoder.height, frame_->format = encoder.pix_fmt;
  frame_->color_primaries = encoder.color_primaries, frame_->color_trc = encoder.color_trc;
  frame_->colorspace = encoder.colorspace, frame_->color_range = encoder.color_range;
  frame_->pts = -1;
  libav::check_memory(av_frame_get_buffer(frame_.get(), PictureConverter::kAlignment_bytes));
  return {};
}

Result<void> VideoWriter::write_header(const VideoFormat& format) {
  AVFormatContext& muxer = *muxer_;
  AVStream* stream = libav::allocated(avformat_new_stream(&muxer, nullptr));
  libav::check_memory(avcodec_parameters_from_context(stream->codecpar, encoder_.get()));
  is_numbered_ = format.container == VideoContainer::Y4m;
  stream->time_base = is_numbered_ ? encoder_->time_base : kMicroseconds;
  stream->avg_frame_rate = encoder_->framerate;
  if (is_mp4(format.container) && format.codec == VideoCodec::Hevc)
    stream->codecpar->codec_tag = MKTAG('h', 'v', 'c', '1');  // what Apple's players ask for
  if (format.mastering) {
    stated_ = bound_of(*format.mastering);
    add_to(*stream, *format.mastering, *stated_);
  }
  muxer.flags |= AVFMT_FLAG_CUSTOM_IO | AVFMT_FLAG_BITEXACT | AVFMT_FLAG_FLUSH_PACKETS;
  muxer.strict_std_compliance = FF_COMPLIANCE_EXPERIMENTAL;  // Y4M of 10 bits
  if (is_mp4(format.container)) {
    av_opt_set(muxer.priv_data, "movflags", "frag_keyframe+empty_moov+default_base_moof", 0);
    longest_step_us_ = 2'000'000'000;  // its durations have 32 bits, of which the muxer takes 31
  }
  if (format.container == VideoContainer::Matroska)
    av_opt_set_int(muxer.priv_data, "cluster_time_limit", std::lround(kFragment_s * 1e3), 0);
  if (format.container == VideoContainer::Matroska && format.mastering)
    av_opt_set_int(muxer.priv_data, "write_crc32", 0, 0);  // finish() changes what they would cover

  // The header first into memory, so that it is known where it states what finish() may have to change.
  libav::check_memory(avio_open_dyn_buf(&muxer.pb));
  const int code = avformat_write_header(&muxer, nullptr);
  std::uint8_t* bytes = nullptr;
  const int size = avio_close_dyn_buf(std::exchange(muxer.pb, stream_.context()), &bytes);
  header_.assign(bytes, bytes + size);
  av_free(bytes);
  if (code < 0)
    return Error{ErrorCode::Unsupported,
                 fmt::format("{} cannot hold this video: {}; choose another container", muxer.oformat->name,
                             libav::words(code))};
  avio_write(muxer.pb, header_.data(), size);
  avio_flush(muxer.pb);
  return checked(0, "write the header of the video");
}

// The storage's own error before the library's number for it.
Result<void> VideoWriter::checked(int code, const char* what) {
  if (stream_.failure()) return *stream_.failure();
  if (code < 0) return Error{ErrorCode::Io, fmt::format("cannot {}: {}", what, libav::words(code))};
  return {};
}

PicturePlanes VideoWriter::planes() {
  libav::check_memory(av_frame_make_writable(frame_.get()));
  PicturePlanes planes;
  for (std::size_t i = 0; i < 3; ++i)
    planes.data[i] = frame_->data[i], planes.stride_bytes[i] = frame_->linesize[i];
  return planes;
}

Result<void> VideoWriter::append(Duration since_start) {
  const auto us = std::chrono::round<std::chrono::microseconds>(since_start).count() - left_out_us_;
  const std::int64_t step_us = std::max<std::int64_t>(us - last_us_, 1);
  const std::int64_t shown_us = std::min(step_us, longest_step_us_);
  left_out_us_ += step_us - shown_us;
  times_us_.push_back(last_us_ += shown_us);
  ++frame_->pts;
  if (const int code = avcodec_send_frame(encoder_.get(), frame_.get()); code < 0)
    return Error{ErrorCode::Unsupported, fmt::format("{} failed at frame {}: {}", encoder_->codec->name,
                                                     frame_->pts, libav::words(code))};
  return write_packets();
}

Result<void> VideoWriter::write_packets() {
  AVPacket* packet = packet_.get();
  const AVStream& stream = *muxer_->streams[0];
  for (;;) {
    const int code = avcodec_receive_packet(encoder_.get(), packet);
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return {};
    TRY(checked(code, "encode a frame"));
    while (first_inside_ < packet->pts && times_us_.size() > 1) times_us_.pop_front(), ++first_inside_;
    if (!is_numbered_) {
      const std::int64_t at = av_rescale_q(times_us_.front(), kMicroseconds, stream.time_base);
      packet->pts = packet->dts = last_written_ = std::max(at, last_written_ + 1);
      packet->duration = av_rescale_q(1, av_inv_q(encoder_->framerate), stream.time_base);
    }
    packet->stream_index = 0;
    TRY(checked(av_write_frame(muxer_.get(), packet), "write a frame"));
  }
}

Result<void> VideoWriter::state_light_level(const LightLevel& level) {
  for (const BytePatch& patch : light_level_patches(header_, *stated_, level))
    TRY(stream_.file().write_at(patch.offset, std::as_bytes(std::span(patch.bytes))));
  return {};
}

Result<void> VideoWriter::finish(const std::optional<LightLevel>& level) {
  avcodec_send_frame(encoder_.get(), nullptr);
  TRY(write_packets());
  const int code = av_write_trailer(muxer_.get());
  avio_flush(muxer_->pb);
  TRY(checked(code, "write the end of the video"));
  if (level && stated_ && seekable_) TRY(state_light_level(*level));
  return seekable_ ? stream_.file().sync() : Result<void>();
}

}  // namespace hdrcam
