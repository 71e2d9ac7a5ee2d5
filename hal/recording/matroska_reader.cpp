// Reads a recording: packets come in pairs, a picture and its facts, and are returned only when the checksum
// over both is right. It holds one frame at a time. After damage libavformat may miss frames: if damage is
// skipped, the reader then finds the clusters itself (cluster_scan.h).
#include <algorithm>
#include <array>
#include <climits>
#include <utility>

#include "hal/core/counted.h"
#include "hal/core/sound_facts.h"
#include "hal/recording/cluster_scan.h"
#include "hal/recording/facts_json.h"
#include "hal/recording/matroska.h"
#include "hal/recording/picture_codec.h"
#include "hal/recording/recording.h"
#include "hal/recording/storage_stream.h"

namespace hdrcam {
namespace {

// The container: packets in the order of the file.
struct Container {
  std::unique_ptr<StorageStream> stream;  // outlives the demuxer
  libav::Demuxer demuxer;
  bool whole = false;        // finished, and not truncated since
  std::uint64_t end = 0;     // where it ends, if it is whole
  std::uint64_t behind = 0;  // bytes of another Matroska file that follows this one

  std::span<AVStream*> tracks() const { return {demuxer->streams, demuxer->nb_streams}; }
};

// Where the recording ends if finish() completed, else nullopt: the Segment, the second element of a Matroska
// file, then has a size, and the file is that long. Element: identifier, size, content.
Result<std::optional<std::uint64_t>> end_of_whole(StorageFile& file) {
  constexpr std::uint64_t kIdentifier = 4;  // bytes, of both elements
  constexpr std::optional<std::uint64_t> kCut;
  const std::uint64_t file_size = TRY(file.size());
  std::array<std::byte, 64> head{};
  const std::uint64_t known = TRY(file.read_at(0, head));
  std::uint64_t at = 0;
  for (int element = 0; element < 2; ++element) {
    at = std::min(at + kIdentifier, known);
    const auto size = matroska::size_in(std::span<const std::byte>(head).subspan(at, known - at));
    if (!size || size->bytes > file_size || at + size->length + size->bytes > file_size) return kCut;
    at += size->length + size->bytes;
  }
  return std::optional(at);
}

// The bytes of another Matroska file that begins there; 0 for none.
Result<std::uint64_t> bytes_behind(StorageFile& file, std::uint64_t end) {
  std::array<std::byte, matroska::kFileHead.size()> head{};
  const bool another = TRY(file.read_at(end, head)) == head.size() && head == matroska::kFileHead;
  return another ? TRY(file.size()) - end : 0;
}

constexpr const char* kImportMakesOne = "'hdrcam import' makes a recording of pictures, videos and clips";

Result<Container> open_container(Storage& storage, const std::string& path) {
  libav::be_quiet();
  if (TRY(storage.look_at(path)).kind == FileKind::Folder)
    return Error{ErrorCode::NotRecording,
                 fmt::format("'{}' is a folder and not a recording; {}", path, kImportMakesOne)};
  Container container;
  container.stream = std::make_unique<StorageStream>(TRY(storage.open(path)), StorageStream::Direction::Read);
  std::array<std::byte, 4> head{};
  const std::size_t known = TRY(container.stream->file().read_at(0, head));
  if (known == 0) return Error{ErrorCode::Truncated, fmt::format("'{}' is empty; copy it again", path)};
  if (!std::equal(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(known),
                  matroska::kFileHead.begin()))
    return Error{
        ErrorCode::NotRecording,
        fmt::format("'{}' is not a recording: it is not a Matroska file; {}", path, kImportMakesOne)};

  StorageFile& file = container.stream->file();
  const std::optional<std::uint64_t> end = TRY(end_of_whole(file));
  container.whole = end.has_value();
  container.end = end.value_or(0);
  if (end) container.behind = TRY(bytes_behind(file, *end));
  AVFormatContext* demuxer = libav::allocated(avformat_alloc_context());
  demuxer->pb = container.stream->context();
  demuxer->flags |= AVFMT_FLAG_CUSTOM_IO | AVFMT_FLAG_NOPARSE | AVFMT_FLAG_NOFILLIN;
  // Frees the demuxer on failure, and then it is null; it may be open though a read of it failed.
  const int code = avformat_open_input(&demuxer, nullptr, av_find_input_format("matroska"), nullptr);
  container.demuxer.reset(demuxer);
  if (container.stream->failure()) return *container.stream->failure();
  if (code < 0 && !container.whole && !TRY(holds_cluster(file)))
    return Error{ErrorCode::Truncated, fmt::format("'{}' ends before its first frame", path)};
  if (code < 0)
    return Error{ErrorCode::Corrupt, fmt::format("'{}' is damaged: its header cannot be read", path)};
  return container;
}

// Other programs can put the tracks in another order, and others beside them.
Error misplaced_tracks(const Container& container, const std::string& path) {
  const auto count = [&](AVMediaType type) {
    return std::ranges::count(container.tracks(), type,
                              [](const AVStream* track) { return track->codecpar->codec_type; });
  };
  if (count(AVMEDIA_TYPE_VIDEO) == 0 || count(AVMEDIA_TYPE_SUBTITLE) == 0)
    return {ErrorCode::Corrupt,
            fmt::format("'{}' is damaged: it lacks its track of pixels or of facts", path)};
  return {ErrorCode::Corrupt,
          fmt::format("'{}' has its tracks of pixels and of facts in another order, or others beside them; "
                      "'ffmpeg -i FILE -map 0:v:0 -map 0:s:0 -c copy other.mkv' puts them right",
                      path)};
}

Result<CameraFacts> camera_of(const Container& container, const std::string& path) {
  const AVDictionaryEntry* tag = av_dict_get(container.demuxer->metadata, matroska::kCameraTag, nullptr, 0);
  if (tag == nullptr)
    return Error{
        ErrorCode::NotRecording,
        fmt::format("'{}' is a Matroska file, but not a recording of hdrcam; {}", path, kImportMakesOne)};
  const auto tracks = container.tracks();
  const auto is_at = [&](std::size_t i, AVMediaType type) { return tracks[i]->codecpar->codec_type == type; };
  if (tracks.size() != 2 || !is_at(matroska::kPixelTrack, AVMEDIA_TYPE_VIDEO) ||
      !is_at(matroska::kFactsTrack, AVMEDIA_TYPE_SUBTITLE))
    return misplaced_tracks(container, path);
  if (!seal_holds(tag->value, unsealed_head(*tracks[matroska::kPixelTrack]->codecpar)))
    return Error{ErrorCode::Corrupt,
                 fmt::format("'{}' is damaged: the checksum of its camera facts does not hold", path)};
  auto camera = camera_from_json(tag->value);
  if (camera) {
    if (auto recordable = check_recordable(*camera); !recordable) camera = recordable.error();
  }
  if (!camera) return Error{camera.error().code, fmt::format("'{}': {}", path, camera.error().message)};
  if (const auto objection = objection_to(*camera))
    return Error{ErrorCode::Corrupt, fmt::format("'{}' cannot be of a camera: {}", path, *objection)};
  return camera;
}

std::string_view text_of(const AVPacket& packet) {
  return {reinterpret_cast<const char*>(packet.data), static_cast<std::size_t>(packet.size)};
}

// The number of frames, from the end record, which the index locates; another recording that was put in the
// place of a lost end has its own. It opens its own container, because it seeks.
std::optional<int> count_frames(Storage& storage, const std::string& path, const CameraFacts& camera) {
  auto container = open_container(storage, path);
  if (!container) return std::nullopt;
  AVFormatContext* demuxer = container->demuxer.get();
  if (av_seek_frame(demuxer, matroska::kFactsTrack, INT64_MAX, AVSEEK_FLAG_BACKWARD) < 0) return std::nullopt;
  const libav::Packet packet(libav::allocated(av_packet_alloc()));
  for (; av_read_frame(demuxer, packet.get()) >= 0; av_packet_unref(packet.get())) {
    if (packet->stream_index != matroska::kFactsTrack || !seal_holds(text_of(*packet), {})) continue;
    const auto record = record_from_json(text_of(*packet), camera.bits);
    if (!record || !record.value().is_end) continue;
    if (packet->pos < 0 || static_cast<std::uint64_t>(packet->pos) >= container->end) return std::nullopt;
    const std::uint64_t frames = record.value().index;
    return std::in_range<int>(frames) ? std::optional(static_cast<int>(frames)) : std::nullopt;
  }
  return std::nullopt;
}

class MatroskaReader : public RecordingReader {
 public:
  static Result<std::unique_ptr<RecordingReader>> open(Storage& storage, const std::string& path,
                                                       Damage damage);
  const CameraFacts& camera() const override { return camera_; }
  RecordingCodec codec() const override { return decoder_.codec(); }
  std::optional<int> frame_count() const override { return count_; }
  Result<std::optional<RawFrame>> next(RawFrame room) override;
  Result<std::optional<FrameFacts>> next_facts() override { return advance(); }
  const LeftOut& left_out() const override { return left_out_; }
  std::uint64_t bytes_behind() const override { return container_.behind; }

 private:
  // A frame with a valid checksum whose picture is in picture_; nullopt at the end.
  using Advance = Result<std::optional<FrameFacts>>;

  MatroskaReader(std::string path, Damage damage, Container container, CameraFacts camera,
                 PictureDecoder decoder)
      : path_(std::move(path)),
        damage_(damage),
        container_(std::move(container)),
        camera_(std::move(camera)),
        decoder_(std::move(decoder)) {}

  Advance advance();
  Advance read_pair();
  Advance prove(std::string_view text);
  void begin_search(const std::string& damage);
  Advance search();
  Result<FactsRecord> proved(const FoundCluster& found) const;
  Result<bool> stands_too_early(std::uint64_t index) const;
  Advance prove_found(const FoundCluster& found);
  Error corrupt(const std::string& what) const;
  bool is_whole() const;
  Error ended();
  void look_behind();
  void leave_out(std::uint64_t first, std::uint64_t end, const std::string& reason);

  std::string path_;
  const Damage damage_;
  Container container_;
  CameraFacts camera_;
  PictureDecoder decoder_;
  std::optional<int> count_;
  libav::Packet picture_{libav::allocated(av_packet_alloc())}, packet_{libav::allocated(av_packet_alloc())};
  bool has_picture_ = false;          // picture_ waits for its facts
  std::optional<Advance> ahead_;      // the first frame: read when the file was opened
  std::optional<Advance> last_;       // the end or the error, which stays
  std::uint64_t frames_ = 0;          // the place of the next frame
  std::uint64_t facts_at_ = 0;        // in the file, of the block of the last proved facts
  std::uint64_t facts_end_ = 0;       // of that block
  std::optional<FrameFacts> before_;  // of the last frame
  std::optional<ClusterScan> scan_;   // once there was damage
  bool scan_found_end_ = false;
  LeftOut left_out_;
};

Result<std::unique_ptr<RecordingReader>> MatroskaReader::open(Storage& storage, const std::string& path,
                                                              Damage damage) {
  auto container = TRY(open_container(storage, path));
  auto camera = TRY(camera_of(container, path));
  auto decoder = PictureDecoder::open(camera, *container.tracks()[matroska::kPixelTrack]->codecpar);
  if (!decoder)
    return Error{decoder.error().code, fmt::format("'{}' is damaged: {}", path, decoder.error().message)};
  std::unique_ptr<MatroskaReader> reader(
      new MatroskaReader(path, damage, std::move(container), std::move(camera), std::move(*decoder)));
  if (reader->container_.whole) reader->count_ = count_frames(storage, path, reader->camera_);
  auto first = reader->advance();
  if (!first && first.error().code == ErrorCode::Truncated)
    return Error{ErrorCode::Truncated, fmt::format("'{}' ends before its first frame", path)};
  reader->ahead_ = std::move(first);
  return std::unique_ptr<RecordingReader>(std::move(reader));
}

Error MatroskaReader::corrupt(const std::string& what) const {
  return {ErrorCode::Corrupt, fmt::format("'{}' is damaged at frame {}: {}", path_, frames_, what)};
}

// Still: another program may have cut it since it was opened.
bool MatroskaReader::is_whole() const {
  if (!container_.whole) return false;
  const auto size = container_.stream->file().size();
  return !size || size.value() >= container_.end;
}

// No packet is left, and there was no end record.
Error MatroskaReader::ended() {
  if (is_whole()) return corrupt("the rest of the file cannot be read");
  look_behind();
  const std::string frames = counted(frames_ - left_out_.count, "whole frame");
  if (!container_.whole)
    return {ErrorCode::Truncated,
            fmt::format("'{}' was cut after {}, or is still being written", path_, frames)};
  const std::string all = count_ ? fmt::format(" of {}", *count_) : "";
  return {ErrorCode::Truncated,
          fmt::format("'{}' was cut while it was read, after {}{}", path_, frames, all)};
}

// Nothing says where a recording ends that was cut: what was put behind it is searched for.
void MatroskaReader::look_behind() {
  StorageFile& file = container_.stream->file();
  const auto other = ClusterScan(file, facts_end_, 0).other_file();
  const auto size = file.size();
  if (other && other.value() && size) container_.behind = size.value() - *other.value();
}

// The frames of the places first .. end-1 are not to be had.
void MatroskaReader::leave_out(std::uint64_t first, std::uint64_t end, const std::string& reason) {
  if (end <= first) return;
  if (left_out_.reason.empty()) left_out_.reason = reason;
  left_out_.count += end - first;
  for (; first < end && left_out_.places.size() < LeftOut::kPlaces; ++first)
    left_out_.places.push_back(first);
}

MatroskaReader::Advance MatroskaReader::advance() {
  if (last_) return *last_;
  if (ahead_) {
    Advance first = std::move(*ahead_);
    ahead_.reset();
    return first;
  }
  Advance step = scan_ ? search() : read_pair();
  if (!step && step.error().code == ErrorCode::Corrupt && damage_ == Damage::IsSkipped && !scan_) {
    begin_search(step.error().message);
    step = search();
  }
  if (!step || !step.value()) last_ = step;
  return step;
}

MatroskaReader::Advance MatroskaReader::read_pair() {
  for (;;) {
    const int code = av_read_frame(container_.demuxer.get(), packet_.get());
    if (container_.stream->failure()) return *container_.stream->failure();
    if (code == AVERROR_EOF) return ended();
    if (code < 0) return corrupt(libav::words(code));
    if (packet_->stream_index == matroska::kPixelTrack) {
      if (has_picture_) return corrupt("a picture has no facts");
      av_packet_unref(picture_.get());
      av_packet_move_ref(picture_.get(), packet_.get());
      has_picture_ = true;
    } else if (packet_->stream_index == matroska::kFactsTrack) {
      return prove(text_of(*packet_));
    }
    av_packet_unref(packet_.get());
  }
}

MatroskaReader::Advance MatroskaReader::prove(std::string_view text) {
  std::span<const std::uint8_t> pixels;
  if (has_picture_) pixels = {picture_->data, static_cast<std::size_t>(picture_->size)};
  if (!seal_holds(text, pixels)) return corrupt("the checksum over its pixels and facts does not hold");
  auto record = record_from_json(text, camera_.bits);
  if (!record) return corrupt(record.error().message);
  if (record->index != frames_)
    return corrupt(fmt::format("{} {} follows", record->is_end ? "the end record of a file of" : "frame",
                               record->index));
  if (record->is_end == has_picture_) return corrupt("a picture and its facts do not belong together");
  if (record->is_end) return std::optional<FrameFacts>();
  if (const auto objection = objection_to(record->facts, before_ ? &*before_ : nullptr))
    return corrupt(*objection);
  facts_at_ = static_cast<std::uint64_t>(std::max<std::int64_t>(0, packet_->pos));
  facts_end_ = facts_at_ + matroska::kBlockHead + text.size();
  av_packet_unref(packet_.get());
  has_picture_ = false;
  ++frames_;
  before_ = record->facts;
  return std::optional<FrameFacts>(record->facts);
}

// From the last whole frame on.
void MatroskaReader::begin_search(const std::string& damage) {
  const std::uint64_t frame_bytes = sizeof(std::uint16_t) *
                                    static_cast<std::uint64_t>(channels(camera_.layout)) *
                                    pixel_count(camera_.height, camera_.width);
  constexpr std::uint64_t kFactsBytes = 1 << 20;  // at most; a picture takes less than twice its codes
  scan_.emplace(container_.stream->file(), facts_at_,
                std::min<std::uint64_t>(2 * frame_bytes + kFactsBytes, INT_MAX), facts_end_);
  left_out_.reason = damage.substr(std::min(damage.size(), damage.rfind(": ") + 2));
}

// The next whole frame of a damaged file, whatever lies between.
MatroskaReader::Advance MatroskaReader::search() {
  for (;;) {
    const auto found = TRY(scan_->next());
    if (!found) break;
    Advance frame = prove_found(*found);
    if (!frame && frame.error().code != ErrorCode::Corrupt) return frame;
    if (!frame) continue;
    if (frame.value()) return frame;
    if (scan_found_end_) return frame;
  }
  left_out_.end_is_missing = !count_;
  if (!is_whole()) return ended();
  if (!count_) look_behind();
  leave_out(frames_, static_cast<std::uint64_t>(std::max(0, count_.value_or(0))), left_out_.reason);
  return std::optional<FrameFacts>();
}

// Corrupt where no checksum holds.
Result<FactsRecord> MatroskaReader::proved(const FoundCluster& found) const {
  if (!seal_holds(found.facts, found.picture)) return corrupt("no checksum holds");
  auto record = record_from_json(found.facts, camera_.bits);
  if (!record) return corrupt(record.error().message);
  return record;
}

// Whether frames follow that come before the one of this number: its bytes were copied to an earlier place.
// As many frames are looked at as it would leave out, so that a gap costs no more than the frames lost in it:
// a longer run of bytes that were copied over others has covered those itself.
Result<bool> MatroskaReader::stands_too_early(std::uint64_t index) const {
  ClusterScan ahead = *scan_;
  for (std::uint64_t looked_at = frames_; looked_at < index;) {
    const auto found = TRY(ahead.next());
    if (!found) break;
    const auto record = proved(*found);
    if (!record) continue;
    ahead.accept();
    const FactsRecord& read = record.value();
    if (read.index < frames_) continue;
    if (read.index <= index && !read.is_end) return true;
    ++looked_at;
  }
  return false;
}

// A frame; nullopt for one that came before or stands too early, and for the end record; Corrupt for what is
// none of them.
MatroskaReader::Advance MatroskaReader::prove_found(const FoundCluster& found) {
  const FactsRecord read = TRY(proved(found));
  scan_->accept();
  if (TRY(stands_too_early(read.index))) return std::optional<FrameFacts>();
  leave_out(frames_, read.index, left_out_.reason);
  if (read.is_end) return scan_found_end_ = true, std::optional<FrameFacts>();
  if (read.index < frames_) return std::optional<FrameFacts>();
  frames_ = read.index + 1;
  if (const auto objection = objection_to(read.facts, before_ ? &*before_ : nullptr)) {
    leave_out(read.index, frames_, *objection);
    return std::optional<FrameFacts>();
  }
  av_packet_unref(picture_.get());
  if (av_new_packet(picture_.get(), static_cast<int>(found.picture.size())) < 0)
    return Error{ErrorCode::Io, fmt::format("no memory for frame {} of '{}'", read.index, path_)};
  std::ranges::copy(found.picture, picture_->data);
  before_ = read.facts;
  return std::optional<FrameFacts>(read.facts);
}

Result<std::optional<RawFrame>> MatroskaReader::next(RawFrame room) {
  for (;;) {
    auto facts = TRY(advance());
    if (!facts) return std::optional<RawFrame>();
    const auto decoded = decoder_.decode(*picture_, room.codes);
    if (decoded) return std::optional(RawFrame{std::move(*facts), std::move(room.codes)});
    if (damage_ == Damage::IsSkipped) {
      leave_out(frames_ - 1, frames_, decoded.error().message);
      continue;
    }
    last_ = Advance(Error{ErrorCode::Corrupt, fmt::format("'{}' is damaged at frame {}: {}", path_,
                                                          frames_ - 1, decoded.error().message)});
    return last_->error();
  }
}

}  // namespace

Result<std::unique_ptr<RecordingReader>> open_recording(Storage& storage, const std::string& path,
                                                        Damage damage) {
  return MatroskaReader::open(storage, path, damage);
}

}  // namespace hdrcam
