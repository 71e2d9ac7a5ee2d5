#include "hal/footage/video_file.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

#include "hal/core/parse_number.h"
#include "hal/footage/exif_exposure.h"
#include "hal/footage/exif_segments.h"
#include "hal/footage/footage.h"
#include "hal/footage/icc_primaries.h"
#include "hal/footage/mp4_index.h"
#include "hal/footage/tiff_objection.h"

namespace hdrcam {
namespace {

// Whether its rows are of two moments. FFmpeg also calls a PNG interlaced whose rows are only stored in
// another order (Adam7).
bool is_interlaced(const AVFrame& frame, AVCodecID codec) {
  return libav::is_interlaced(frame) && codec != AV_CODEC_ID_PNG && codec != AV_CODEC_ID_APNG;
}

// A file is what was named: a playlist opens no others, and nothing on a network.
int open_nothing(AVFormatContext*, AVIOContext**, const char*, int, AVDictionary**) {
  return AVERROR(EACCES);
}

// Of EXIF's rational numbers.
enum class ExifRational { Signed, Unsigned };

// A number as FFmpeg prints EXIF's: "1:250", "0.004", "  100", "-1:1". It prints parts of unsigned ones as if
// they were signed: 4000000000:1000000000 as "-294967296:1000000000".
std::optional<double> exif_value(const AVFrame& frame, const char* tag, ExifRational kind) {
  const AVDictionaryEntry* const entry = av_dict_get(frame.metadata, tag, nullptr, 0);
  if (entry == nullptr) return std::nullopt;
  std::string_view text = entry->value;
  const auto take = [&text](double& value) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return error == std::errc();
  };
  double value = 0, divisor = 1;
  if (!take(value)) return std::nullopt;
  if (text.starts_with(':') || text.starts_with('/')) {
    text.remove_prefix(1);
    if (!take(divisor) || divisor == 0) return std::nullopt;
    for (double* const part : {&value, &divisor})
      if (kind == ExifRational::Unsigned && *part < 0) *part += 0x1p32;
  }
  return value / divisor;
}

std::optional<double> if_positive(std::optional<double> value) {
  return value && std::isfinite(*value) && *value > 0 ? value : std::nullopt;
}

std::optional<double> exif_number(const AVFrame& frame, const char* tag) {
  return if_positive(exif_value(frame, tag, ExifRational::Unsigned));
}

// "00:01:02.500000000", as Matroska states the end of a track; seconds.
std::optional<double> clock_time_s(std::string_view text) {
  double time_s = 0;
  for (int part = 0; part < 3; ++part) {
    const std::size_t colon = text.find(':');
    if ((colon == std::string_view::npos) != (part == 2)) return std::nullopt;
    const auto number = parse_number<double>(text.substr(0, colon));
    if (!number) return std::nullopt;
    time_s = 60 * time_s + *number;
    if (part < 2) text.remove_prefix(colon + 1);
  }
  return time_s;
}

// FFmpeg has one demuxer for all of that family, "mov,mp4,m4a,..".
bool is_mp4_or_mov(const AVFormatContext& demuxer) {
  return std::string_view(demuxer.iformat->name).starts_with("mov");
}

// When a track ends, as its file states it: for the track, or for all where it is the only one.
std::optional<double> stated_end_s(const AVFormatContext& demuxer, const AVStream& track) {
  const std::string_view container = demuxer.iformat->name;
  // Elsewhere it may be that of the file which this one was made of.
  if (const AVDictionaryEntry* const entry = av_dict_get(track.metadata, "DURATION", nullptr, 0);
      entry != nullptr && container.starts_with("matroska"))
    if (const auto end_s = clock_time_s(entry->value)) return end_s;
  if (container == "avi" && track.nb_frames > 0)
    return static_cast<double>(track.nb_frames) * av_q2d(track.time_base);
  const bool stated = demuxer.duration_estimation_method == AVFMT_DURATION_FROM_STREAM;
  if (demuxer.nb_streams != 1 || !stated || demuxer.duration <= 0) return std::nullopt;
  return static_cast<double>(demuxer.duration) / AV_TIME_BASE;
}

std::string_view exif_text(const AVFrame& frame, const char* tag) {
  const AVDictionaryEntry* const entry = av_dict_get(frame.metadata, tag, nullptr, 0);
  return entry != nullptr ? entry->value : "";
}

// Exif 2.3, 4.6.5: PhotographicSensitivity has 16 bits, and its largest value stands for any beyond, which
// one of three others states; some files have only one of these. FFmpeg has no names for them, newer ones do.
std::optional<double> exif_iso(const AVFrame& frame) {
  constexpr double kOrMore = 65535;
  const auto iso = exif_number(frame, "ISOSpeedRatings");
  if (iso && *iso < kOrMore) return iso;
  for (const char* const tag :
       {"0x8832", "RecommendedExposureIndex", "0x8833", "ISOSpeed", "0x8831", "StandardOutputSensitivity"})
    if (const auto stated = exif_number(frame, tag)) return stated;
  return std::nullopt;
}

bool states(const AVFrame& frame, const char* tag) {
  return av_dict_get(frame.metadata, tag, nullptr, 0) != nullptr;
}

// Exif 2.3, annex C: files without ExposureTime or FNumber may have their APEX values, Tv = -log2(time / s)
// and Av = 2 log2(N), mostly rounded. Beside one that is 0, as of a lens without contacts, they say nothing.
std::optional<double> exif_time_s(const AVFrame& frame) {
  if (states(frame, "ExposureTime")) return exif_number(frame, "ExposureTime");
  const auto apex = exif_value(frame, "ShutterSpeedValue", ExifRational::Signed);
  return apex ? if_positive(std::exp2(-*apex)) : std::nullopt;
}

std::optional<double> exif_f_number(const AVFrame& frame) {
  if (states(frame, "FNumber")) return exif_number(frame, "FNumber");
  // Unsigned by the standard, but that of a lens faster than f/1 is negative.
  const auto apex = exif_value(frame, "ApertureValue", ExifRational::Signed);
  return apex ? if_positive(std::exp2(*apex / 2)) : std::nullopt;
}

std::optional<ExifExposure> exif_exposure(const AVFrame& frame) {
  const auto time_s = exif_time_s(frame);
  if (!time_s) return std::nullopt;
  return ExifExposure{*time_s, exif_iso(frame), exif_f_number(frame)};
}

// Other than BT.709's, as its tags (ITU-T H.273) or its colour profile state them. Those of standard
// definition are near enough.
std::string primaries_of(const AVFrame& frame) {
  const AVFrameSideData* const profile = av_frame_get_side_data(&frame, AV_FRAME_DATA_ICC_PROFILE);
  if (profile != nullptr && states_other_primaries(std::span(profile->data, profile->size)))
    return "a colour profile";
  switch (frame.color_primaries) {
    case AVCOL_PRI_FILM:
    case AVCOL_PRI_BT2020:
    case AVCOL_PRI_SMPTE428:
    case AVCOL_PRI_SMPTE431:
    case AVCOL_PRI_SMPTE432:
      return av_color_primaries_name(frame.color_primaries);
    default:
      return "";
  }
}

// Of PNG and TIFF, whose EXIF FFmpeg before 8 does not read.
Orientation orientation_in(const AVPacket& packet, AVCodecID codec) {
  const std::span file(packet.data, static_cast<std::size_t>(packet.size));
  if (codec == AV_CODEC_ID_PNG) return orientation_in_png(file);
  return codec == AV_CODEC_ID_TIFF ? orientation_in_tiff(file) : Orientation::Upright;
}

std::optional<Orientation> orientation_of(const std::uint8_t* display_matrix) {
  std::array<std::int32_t, 9> matrix{};
  std::memcpy(matrix.data(), display_matrix, sizeof matrix);
  return orientation_of_matrix(matrix);
}

// As the frame states it, else the packet it comes from, else the file. FFmpeg makes a matrix of a JPEG's
// EXIF. None: by another angle.
std::optional<Orientation> stated_orientation(const AVFrame& frame, Orientation in_packet,
                                              const AVStream& stream) {
  if (const auto* const of_frame = av_frame_get_side_data(&frame, AV_FRAME_DATA_DISPLAYMATRIX))
    return orientation_of(of_frame->data);
  for (const Orientation stated :
       {orientation_of_exif(exif_number(frame, "Orientation").value_or(1)), in_packet})
    if (stated != Orientation::Upright) return stated;
  const std::uint8_t* const of_stream = libav::side_data(stream, AV_PKT_DATA_DISPLAYMATRIX);
  return of_stream != nullptr ? orientation_of(of_stream) : Orientation::Upright;
}

// ISO/IEC 14496-12: the first box is the file's type, "ftyp", with its brand: "isom". "": no such file.
Result<std::string> brand_of(Storage& storage, const std::string& path) {
  const auto file = TRY(storage.open(path));
  std::array<char, 12> head{};
  TRY(file->read_at(0, std::as_writable_bytes(std::span(head))));
  const std::string_view type(head.data() + 4, 8);
  return std::string(type.starts_with("ftyp") ? type.substr(4) : "");
}

// Why FFmpeg could not open a file of that brand.
const char* why_unread(const std::string& brand) {
  constexpr std::string_view kPictures[] = {"avif", "heic", "heim", "heis", "heix", "mif1"};
  if (brand.empty()) return "is neither a video nor a picture that FFmpeg knows; convert it, or leave it out";
  if (std::ranges::find(kPictures, brand) != std::end(kPictures))
    return "is a HEIC or AVIF picture, which the FFmpeg of this machine cannot read; convert it to JPEG or "
           "PNG";
  return "is an MP4 or MOV that FFmpeg cannot read; one that was cut has lost its index, which stands at the "
         "end unless the file has fragments";
}

}  // namespace

Error VideoFile::refused(ErrorCode code, const std::string& why) const {
  return {code, fmt::format("'{}' {}", path_, why)};
}

Result<std::unique_ptr<PictureFile>> VideoFile::open(Storage& storage, const std::string& path) {
  libav::be_quiet();
  auto stream = TRY(storage.open(path));
  std::unique_ptr<VideoFile> file(new VideoFile(std::move(stream), path));
  AVFormatContext* demuxer = libav::allocated(avformat_alloc_context());
  demuxer->pb = file->stream_.context();
  demuxer->io_open = open_nothing;
  // Without a name: the content says what it is, and no name is taken for a pattern. On failure the library
  // frees what it was given, and then it is null; it may be open though a read of it failed.
  const int code = avformat_open_input(&demuxer, nullptr, nullptr, nullptr);
  file->demuxer_.reset(demuxer);
  if (file->stream_.failure()) return *file->stream_.failure();
  if (code < 0) return file->refused(ErrorCode::NotRecording, why_unread(TRY(brand_of(storage, path))));
  file->end_byte_ = avio_tell(demuxer->pb);
  TRY(file->open_decoder());
  return std::unique_ptr<PictureFile>(std::move(file));
}

Result<void> VideoFile::open_decoder() {
  if (avformat_find_stream_info(demuxer_.get(), nullptr) < 0)
    return refused(ErrorCode::NotRecording, "holds nothing that FFmpeg can read");
  const AVCodec* codec = nullptr;
  track_ = av_find_best_stream(demuxer_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
  if (track_ < 0) TRY(check_index());
  if (track_ == AVERROR_DECODER_NOT_FOUND)
    return refused(ErrorCode::Unsupported, "is of a codec that the FFmpeg libraries of this machine lack");
  if (track_ < 0) return refused(ErrorCode::NotRecording, "holds no pictures");
  const AVStream& stream = *demuxer_->streams[track_];
  decoder_.reset(libav::allocated(avcodec_alloc_context3(codec)));
  // As many threads as there are processors, on parts of one frame. On several frames, some would refer to
  // one whose damage is not known yet, and which are whole would differ from reading to reading.
  decoder_->thread_count = 0;
  decoder_->thread_type = FF_THREAD_SLICE;
  // No picture whose rest is made up; of TIFF it would refuse every one with a tag that FFmpeg does not know,
  // such as the unit of resolution.
  const bool explodes = codec->id != AV_CODEC_ID_TIFF;
  decoder_->err_recognition = AV_EF_CRCCHECK | (explodes ? AV_EF_EXPLODE : 0);
  if (avcodec_parameters_to_context(decoder_.get(), stream.codecpar) < 0 ||
      avcodec_open2(decoder_.get(), codec, nullptr) < 0)
    return refused(ErrorCode::Unsupported, fmt::format("cannot be decoded as {}", codec->name));
  frame_.reset(libav::allocated(av_frame_alloc()));
  packet_.reset(libav::allocated(av_packet_alloc()));
  const std::string_view demuxer = demuxer_->iformat->name;
  // Demuxers of pictures; a JPEG that holds several may look like a stream of them.
  still_ = demuxer.ends_with("_pipe") || (demuxer == "mjpeg" && is_still(path_));
  facts_.still = still_;
  facts_.framerate_hz = stream.avg_frame_rate.num > 0 && !still_ ? av_q2d(stream.avg_frame_rate) : 0;
  const bool untimed = (demuxer_->iformat->flags & AVFMT_NOTIMESTAMPS) != 0 || demuxer == "yuv4mpegpipe";
  facts_.timed = !still_ && !untimed;
  facts_.format = avcodec_get_name(stream.codecpar->codec_id);
  return {};
}

// Of an MP4 or MOV in which no pictures were found.
Result<void> VideoFile::check_index() {
  if (!is_mp4_or_mov(*demuxer_)) return {};
  if (!TRY(is_index_cut(stream_.file()))) return {};
  return refused(
      ErrorCode::Truncated,
      "is an MP4 or MOV that ends within its index, without which no picture is read; copy it again");
}

// What is damaged on the way is left out and counted; the next whole picture comes.
Result<bool> VideoFile::decode() {
  for (;;) {
    // Behind the picture of a still others may lie, such as a preview or a gain map.
    if (still_ && (codes_.begun() || losses_.damaged > 0)) return false;
    const int code = avcodec_receive_frame(decoder_.get(), frame_.get());
    if (code >= 0 && is_whole()) return true;
    if (code >= 0) continue;
    if (code == AVERROR_EOF) break;
    if (code == AVERROR(EAGAIN))
      TRY(feed());
    else
      lose_until_key();
  }
  losses_.missing = missing_at_end();
  return false;
}

Result<void> VideoFile::feed() {
  const int read = av_read_frame(demuxer_.get(), packet_.get());
  if (stream_.failure()) return *stream_.failure();
  if (read >= 0 && packet_->stream_index == track_) {
    TRY(check_codes(*packet_));
    in_packet_ = orientation_in(*packet_, decoder_->codec_id);
    if (decoder_->codec_id == AV_CODEC_ID_MJPEG && av_packet_make_writable(packet_.get()) >= 0)
      hide_later_exif(std::span(packet_->data, static_cast<std::size_t>(packet_->size)));
    send(*packet_);
  }
  av_packet_unref(packet_.get());
  if (read >= 0) return {};
  const int code = avcodec_send_packet(decoder_.get(), nullptr);  // the end: what is inside comes out
  if (code < 0 && code != AVERROR_EOF) lose_until_key();
  return {};
}

// What the decoder would take wrongly without a word.
Result<void> VideoFile::check_codes(const AVPacket& packet) const {
  if (decoder_->codec_id != AV_CODEC_ID_TIFF) return {};
  const auto objection = objection_to_tiff(std::span(packet.data, static_cast<std::size_t>(packet.size)));
  return objection ? refused(ErrorCode::Unsupported, *objection) : Result<void>{};
}

// A packet that was cut, and those that refer to it, stay outside.
void VideoFile::send(const AVPacket& packet) {
  ++packets_;
  if (packet.pos >= 0) end_byte_ = packet.pos + packet.size;
  const AVStream& track = *demuxer_->streams[track_];
  const std::int64_t begin = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
  const bool timed = packet.duration > 0 || track.avg_frame_rate.num <= 0;
  const std::int64_t duration =
      timed ? packet.duration : av_rescale_q(1, av_inv_q(track.avg_frame_rate), track.time_base);
  if (begin != AV_NOPTS_VALUE) end_ = std::max(end_, av_sat_add64(begin, duration));
  if ((packet.flags & AV_PKT_FLAG_CORRUPT) != 0)
    awaits_key_packet_ = true;
  else if ((packet.flags & AV_PKT_FLAG_KEY) != 0)
    awaits_key_packet_ = false;
  if (awaits_key_packet_)
    ++losses_.damaged;
  else if (avcodec_send_packet(decoder_.get(), &packet) < 0)
    lose_until_key();
}

void VideoFile::lose_until_key() {
  ++losses_.damaged;
  awaits_key_frame_ = true;
}

// Whether the frame that the decoder gave is one to show. A frame after a damaged one refers to it, up to the
// next key frame.
bool VideoFile::is_whole() {
  if ((frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame_->decode_error_flags != 0)
    awaits_key_frame_ = true;
  else if (libav::is_key(*frame_))
    awaits_key_frame_ = false;
  if (awaits_key_frame_) ++losses_.damaged;
  return !awaits_key_frame_;
}

// Whether the file ends inside a frame: of Y4M, which states no number of frames, where what is behind the
// last whole one is longer than the head of a frame; of a file without a whole one, where something is behind
// its head.
bool VideoFile::ends_inside_frame() {
  constexpr std::int64_t kLongestHead = 80;  // bytes, of FFmpeg's demuxer
  const std::string_view container = demuxer_->iformat->name;
  const bool is_known = container == "yuv4mpegpipe" || (packets_ == 0 && container.starts_with("matroska"));
  if (!is_known) return false;
  const auto size = stream_.file().size();
  const std::int64_t end = end_byte_ + (packets_ > 0 ? kLongestHead : 0);
  return size && static_cast<std::int64_t>(size.value()) > end;
}

// By the list of pictures that MP4 and MOV have, elsewhere by the stated end.
int VideoFile::missing_at_end() {
  const AVStream& track = *demuxer_->streams[track_];
  if (still_) return 0;
  if (is_mp4_or_mov(*demuxer_)) return std::max(0, avformat_index_get_entries_count(&track) - packets_);
  constexpr double kRounding = 0.1, kMost = 1e9;  // frames; times are in milliseconds
  const auto stated_s = stated_end_s(*demuxer_, track);
  if (!stated_s || packets_ == 0) return ends_inside_frame() ? 1 : 0;
  const double missing_s = *stated_s - static_cast<double>(end_) * av_q2d(track.time_base);
  const int missing = static_cast<int>(std::clamp(missing_s * facts_.framerate_hz + kRounding, 0.0, kMost));
  return missing == 0 && ends_inside_frame() ? 1 : missing;
}

// From the first frame: how its codes become RGB, and of a still which camera and lens took it.
Result<void> VideoFile::begin_codes() {
  const auto begun = codes_.begin(*frame_, demuxer_->streams[track_]->codecpar->codec_id);
  if (!begun) return refused(begun.error().code, begun.error().message);
  facts_.format += fmt::format(", {}", codes_.format_name());
  facts_.layout = codes_.layout(), facts_.bits = codes_.bits();
  facts_.primaries = primaries_of(*frame_);
  if (still_) {
    facts_.model = camera_model(exif_text(*frame_, "Make"), exif_text(*frame_, "Model"));
    facts_.focal_35mm_mm = exif_number(*frame_, "FocalLengthIn35mmFilm").value_or(0);
  }
  return {};
}

void VideoFile::take_orientation() {
  const auto stated = stated_orientation(*frame_, in_packet_, *demuxer_->streams[track_]);
  facts_.orientation = stated.value_or(Orientation::Upright);
  facts_.oblique |= !stated;
}

Result<bool> VideoFile::next(RawFrame& frame) {
  if (!TRY(decode())) {
    if (packets_ == 0) TRY(check_index());
    if (!codes_.begun() && packets_ == 0 && losses_.missing > 0)
      return refused(ErrorCode::Truncated, "ends before the end of its first frame; copy it again");
    if (!codes_.begun() && (still_ || losses_.damaged > 0))
      return refused(
          ErrorCode::Corrupt,
          "does not decode: it is damaged or cut, or of a kind that FFmpeg does not know; copy it again, "
          "convert it, or leave it out");
    return false;
  }
  if (is_interlaced(*frame_, decoder_->codec_id))
    return refused(
        ErrorCode::Unsupported,
        "is interlaced; make whole frames of it first, each from its own fields, as its neighbours "
        "have other exposures: ffmpeg -vf estdif=mode=frame");
  if (!codes_.begun())
    TRY(begin_codes());
  else if (!codes_.is_like_first(*frame_))
    return refused(ErrorCode::SizeChanged, "changes its size or format on the way");
  take_orientation();
  TRY(codes_.take(*frame_, facts_.orientation, frame.codes));
  frame.facts = {};
  frame.facts.exposure_source = ExposureSource::Unknown;
  const AVRational tick = demuxer_->streams[track_]->time_base;
  const std::int64_t start = demuxer_->streams[track_]->start_time;
  if (frame_->best_effort_timestamp != AV_NOPTS_VALUE)
    frame.facts.timestamp.since_boot = Duration(
        av_rescale_q(av_sat_sub64(frame_->best_effort_timestamp, start == AV_NOPTS_VALUE ? 0 : start), tick,
                     {1, 1'000'000'000}));
  if (const auto stated = exif_exposure(*frame_)) take_exif_exposure(*stated, frame.facts);
  return true;
}

ExifFactors VideoFile::factors() const {
  const auto stated = exif_exposure(*frame_);
  return stated ? factors_of(*stated) : ExifFactors{};
}

// A video's own times are finer, and tell what was lost.
std::optional<ExifTime> VideoFile::taken() const {
  if (facts_.timed) return std::nullopt;
  constexpr const char* kOffsetTimeOriginal = "0x9011";  // FFmpeg has no name for it
  return exif_time(exif_text(*frame_, "DateTimeOriginal"), exif_text(*frame_, "SubSecTimeOriginal"),
                   exif_text(*frame_, kOffsetTimeOriginal));
}

}  // namespace hdrcam
