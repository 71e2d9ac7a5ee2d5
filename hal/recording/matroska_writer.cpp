// Writes a recording: one cluster per frame, each complete before the next one starts.
extern "C" {
#include <libavutil/opt.h>
}

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstring>
#include <new>
#include <utility>

#include "hal/core/sound_facts.h"
#include "hal/recording/facts_json.h"
#include "hal/recording/matroska.h"
#include "hal/recording/nominal_rate.h"
#include "hal/recording/picture_codec.h"
#include "hal/recording/recording.h"
#include "hal/recording/storage_stream.h"

namespace hdrcam {
namespace {

// Of recorded time: the most that a power cut loses.
constexpr Duration kSyncInterval = std::chrono::seconds(1);
constexpr AVRational kMilliseconds = {1, 1000};

// A new file, which goes unless it gets its header: an empty one is no recording.
class EmptyFile {
 public:
  // Both outlive it.
  EmptyFile(Storage& storage, const std::string& path) : storage_(&storage), path_(path) {}
  EmptyFile(const EmptyFile&) = delete;
  EmptyFile& operator=(const EmptyFile&) = delete;
  ~EmptyFile() {
    if (storage_ != nullptr) (void)storage_->remove(path_);
  }
  void keep() { storage_ = nullptr; }

 private:
  Storage* storage_;
  const std::string& path_;
};

class MatroskaWriter : public RecordingWriter {
 public:
  static Result<std::unique_ptr<RecordingWriter>> create(Storage& storage, const std::string& path,
                                                         const CameraFacts& camera, Creation how,
                                                         RecordingCodec codec);
  Result<void> append(const RawFrame& frame) override;
  Result<void> finish() override;

 private:
  MatroskaWriter(Storage& storage, std::string real_path, std::optional<FileInMaking> making,
                 std::unique_ptr<StorageFile> file, PictureEncoder encoder)
      : storage_(storage),
        real_path_(std::move(real_path)),
        making_(std::move(making)),
        stream_(std::move(file), StorageStream::Direction::Write),
        encoder_(std::move(encoder)) {}

  Result<void> write_header(const CameraFacts& camera);
  void add_pixel_track(const CameraFacts& camera);
  void add_facts_track();
  void pack_facts(const std::string& sealed);
  Result<void> write_facts();
  Result<void> end_cluster();
  Result<void> take_name();
  Result<void> checked(int code, const char* what);
  Result<void> sync();

  Storage& storage_;
  const std::string real_path_;
  std::optional<FileInMaking> making_;  // of a file that may replace another: until its first frame is whole
  Durability naming_ = Durability::AtOnce;
  bool name_is_durable_ = false;
  StorageStream stream_;  // outlives the muxer
  PictureEncoder encoder_;
  libav::Muxer muxer_;
  libav::Packet facts_packet_;
  std::optional<Error> failure_;
  bool finished_ = false;
  std::uint64_t frames_ = 0;
  std::optional<FrameFacts> before_;  // of the last frame
  int bits_ = 8;                      // of a code
  Instant first_, synced_;
  std::int64_t pts_ms_ = 0, frame_ms_ = 33;
};

Result<std::unique_ptr<RecordingWriter>> MatroskaWriter::create(Storage& storage, const std::string& path,
                                                                const CameraFacts& camera, Creation how,
                                                                RecordingCodec codec) {
  TRY(check_recordable(camera));
  auto encoder = TRY(PictureEncoder::open(camera, codec));
  const FileFacts there = TRY(storage.look_at(path));
  if (there.kind == FileKind::Other)
    return Error{ErrorCode::Permission,
                 fmt::format("'{}' is a device or a FIFO; a recording needs a regular file", path)};
  std::optional<FileInMaking> making;
  std::optional<EmptyFile> empty;
  if (how == Creation::Replace) making.emplace(TRY(FileInMaking::beside(storage, path)));
  auto file = TRY(making ? making->create() : storage.create(path, Creation::New));
  if (how == Creation::New) empty.emplace(storage, path);
  TRY(file->hold());
  std::unique_ptr<MatroskaWriter> writer(
      new MatroskaWriter(storage, there.real_path, std::move(making), std::move(file), std::move(encoder)));
  if (there.kind == FileKind::Missing) writer->naming_ = Durability::WrittenBack;  // there is nothing to lose
  TRY(writer->write_header(camera));
  if (empty) empty->keep();
  return std::unique_ptr<RecordingWriter>(std::move(writer));
}

Result<void> MatroskaWriter::write_header(const CameraFacts& camera) {
  bits_ = camera.bits;
  AVFormatContext* muxer = nullptr;
  if (const int code = avformat_alloc_output_context2(&muxer, nullptr, "matroska", nullptr); code < 0)
    return Error{ErrorCode::Unsupported, "the FFmpeg libraries of this machine cannot write Matroska"};
  muxer_.reset(muxer);
  facts_packet_.reset(libav::allocated(av_packet_alloc()));
  muxer->pb = stream_.context();
  muxer->flags |= AVFMT_FLAG_CUSTOM_IO | AVFMT_FLAG_BITEXACT;  // the same frames give the same bytes
  frame_ms_ = std::max<std::int64_t>(1, std::llround(1000 / camera.framerate_hz));
  add_pixel_track(camera);
  add_facts_track();
  const std::string facts = seal(to_json(camera, encoder_.codec()),
                                 unsealed_head(*muxer->streams[matroska::kPixelTrack]->codecpar));
  av_dict_set(&muxer->metadata, matroska::kCameraTag, facts.c_str(), 0);
  // The muxer must never end a cluster by itself: a picture and its facts belong in the same one.
  av_opt_set_int(muxer->priv_data, "cluster_size_limit", INT_MAX, 0);
  av_opt_set_int(muxer->priv_data, "cluster_time_limit", INT_MAX, 0);
  TRY(checked(avformat_write_header(muxer, nullptr), "write the header of the recording"));
  avio_flush(muxer->pb);
  return checked(0, "write the header of the recording");
}

void MatroskaWriter::add_pixel_track(const CameraFacts& camera) {
  AVStream* track = libav::allocated(avformat_new_stream(muxer_.get(), nullptr));
  libav::check_memory(avcodec_parameters_from_context(track->codecpar, encoder_.context()));
  // Matroska pads the head of Huffyuv to an even size. The zero is there: behind such data FFmpeg keeps
  // zeros.
  if (encoder_.codec() == RecordingCodec::Huffyuv)
    track->codecpar->extradata_size += track->codecpar->extradata_size % 2;
  track->time_base = kMilliseconds;
  const NominalRate rate = nominal_rate(camera.framerate_hz);
  track->avg_frame_rate = {rate.numerator, rate.denominator};
  track->disposition = AV_DISPOSITION_DEFAULT;
}

void MatroskaWriter::add_facts_track() {
  AVStream* track = libav::allocated(avformat_new_stream(muxer_.get(), nullptr));
  track->codecpar->codec_type = AVMEDIA_TYPE_SUBTITLE;
  track->codecpar->codec_id = AV_CODEC_ID_TEXT;
  track->time_base = kMilliseconds;
  av_dict_set(&track->metadata, "title", "frame facts (JSON)", 0);
  av_dict_set(&track->metadata, "language", "zxx", 0);  // no linguistic content
}

// Prefers the storage's own error to the library's number for it; the first error is kept.
Result<void> MatroskaWriter::checked(int code, const char* what) {
  if (stream_.failure())
    failure_ = stream_.failure();
  else if (code < 0)
    failure_ = Error{ErrorCode::Io, fmt::format("cannot {}: {}", what, libav::words(code))};
  if (failure_) return *failure_;
  return {};
}

Result<void> MatroskaWriter::append(const RawFrame& frame) {
  if (failure_) return *failure_;
  HDRCAM_CHECK(!finished_);
  if (const auto objection = objection_to(frame.facts, before_ ? &*before_ : nullptr))
    return Error{ErrorCode::Invalid, fmt::format("frame {} cannot be recorded: {}", frames_, *objection)};
  AVPacket* picture = TRY(encoder_.encode(frame.codes));
  const Instant now = frame.facts.timestamp;
  if (frames_ == 0) first_ = synced_ = now;
  // A player needs time that runs forward, and a program that copies the tracks orders pictures and facts by
  // it: of two frames in a millisecond the second is one later. The true time is in the facts.
  const auto since_first = std::chrono::duration_cast<std::chrono::milliseconds>(now - first_).count();
  if (frames_ > 0) pts_ms_ = std::max(pts_ms_ + 1, std::int64_t{since_first});
  const std::string facts =
      seal(to_json(frames_, frame.facts, bits_), {picture->data, static_cast<std::size_t>(picture->size)});
  pack_facts(facts);  // where memory ends, before the first byte: a picture without its facts is no frame

  picture->stream_index = matroska::kPixelTrack;
  picture->pts = picture->dts = pts_ms_;
  picture->duration = frame_ms_;
  TRY(checked(av_write_frame(muxer_.get(), picture), "write a frame"));
  TRY(write_facts());
  TRY(end_cluster());
  if (frames_++ == 0) TRY(take_name());
  before_ = frame.facts;
  return now - synced_ >= kSyncInterval ? (synced_ = now, sync()) : Result<void>();
}

void MatroskaWriter::pack_facts(const std::string& sealed) {
  AVPacket* packet = facts_packet_.get();
  av_packet_unref(packet);
  if (av_new_packet(packet, static_cast<int>(sealed.size())) < 0) throw std::bad_alloc();
  std::memcpy(packet->data, sealed.data(), sealed.size());
  packet->stream_index = matroska::kFactsTrack;
  packet->pts = packet->dts = pts_ms_;
  packet->duration = frame_ms_;
  packet->flags |= AV_PKT_FLAG_KEY;
}

Result<void> MatroskaWriter::write_facts() {
  return checked(av_write_frame(muxer_.get(), facts_packet_.get()), "write the facts of a frame");
}

Result<void> MatroskaWriter::end_cluster() {
  const int code = av_write_frame(muxer_.get(), nullptr);
  avio_flush(muxer_->pb);
  return checked(code, "write a frame");
}

// An earlier recording goes when the first frame of this one is on the disk.
Result<void> MatroskaWriter::take_name() {
  if (!making_) return {};
  auto named = making_->commit(naming_);
  if (!named) failure_ = named.error();
  name_is_durable_ = naming_ == Durability::AtOnce;
  return named;
}

// With the first bytes also the name: a power cut would lose them all with it.
Result<void> MatroskaWriter::sync() {
  auto synced = stream_.file().sync();
  if (synced && !std::exchange(name_is_durable_, true)) synced = sync_name(storage_, real_path_);
  if (!synced) failure_ = synced.error();
  return synced;
}

Result<void> MatroskaWriter::finish() {
  if (failure_) return *failure_;
  if (finished_) return {};
  if (making_ && frames_ == 0) return {};  // it has no name
  if (frames_ > 0) pts_ms_ += frame_ms_;
  pack_facts(seal(end_record_json(frames_), {}));
  TRY(write_facts());
  TRY(end_cluster());
  finished_ = true;
  const int code = av_write_trailer(muxer_.get());
  avio_flush(muxer_->pb);
  TRY(checked(code, "write the index of the recording"));
  return sync();
}

}  // namespace

Result<std::unique_ptr<RecordingWriter>> create_recording(Storage& storage, const std::string& path,
                                                          const CameraFacts& camera, Creation how,
                                                          RecordingCodec codec) {
  return MatroskaWriter::create(storage, path, camera, how, codec);
}

}  // namespace hdrcam
