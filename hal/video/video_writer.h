// A video on its way into a file or a pipe: pictures of Y'CbCr 4:2:0 to HEVC, AV1, H.264 or as they are, in
// MP4, MOV, Matroska, NUT or Y4M. MP4 and MOV are fragmented, a fragment a second, Matroska has clusters of a
// second: what is cut plays up to the cut. Frames leave in the order in which they are shown (no
// bidirectional prediction), each at the time that it was given, to the microsecond (Matroska: millisecond;
// Y4M has no times). The brightest light of an HDR10 stream is known at its end: until then the file states
// its mastering display's peak, a bound that holds; finish() puts the measured figures in its place.
// Thread-bound; it owns its file.
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/instant.h"
#include "hal/recording/libav.h"
#include "hal/recording/storage_stream.h"
#include "hal/storage.h"
#include "hal/video/light_level.h"
#include "hal/video/picture_converter.h"

namespace hdrcam {

enum class VideoCodec { Hevc, Av1, H264, Uncompressed };
enum class VideoContainer { Mp4, Mov, Matroska, Nut, Y4m };

// The greatest constant rate factor that the encoder takes: x264 and x265 51, libaom 63.
constexpr int greatest_crf(VideoCodec codec) { return codec == VideoCodec::Av1 ? 63 : 51; }

// By the extension, in letters of either case: .mp4, .mov, .mkv; nullopt for any other.
std::optional<VideoContainer> video_container_of(std::string_view path);

struct VideoFormat {
  int width_px = 0, height_px = 0;  // of the pictures; the video's are even, the last column or row twice
  double framerate_hz = 30;
  int bits = 10;  // 8 or 10
  VideoCodec codec = VideoCodec::Hevc;
  VideoContainer container = VideoContainer::Mp4;
  ColorTags tags = {};
  ChromaSite chroma_site = ChromaSite::Left;  // of the planes to fill, and as stream and container state it
  int crf = 16;                               // constant rate factor, 0..greatest_crf(); less is better
  std::optional<MasteringDisplay> mastering = {};

  int coded_width_px() const { return (width_px + 1) & ~1; }
  int coded_height_px() const { return (height_px + 1) & ~1; }
  PictureFormat picture() const;  // of the planes to fill
};

// Errors: Unsupported where the codec takes no pictures so small, naming the least that it takes.
Result<void> check_picture_size(const VideoFormat& format);

class VideoWriter {
 public:
  // Errors: Unsupported where the FFmpeg libraries of this machine lack the codec, or the codec the size;
  // those of the disk.
  static Result<std::unique_ptr<VideoWriter>> create(std::unique_ptr<StorageFile> file,
                                                     StorageStream::Direction direction,
                                                     const VideoFormat& format);

  // Of the next picture, to be filled before append().
  PicturePlanes planes();
  // since_start: of the first picture; what does not come after the picture before it is moved behind it.
  // Errors: Unsupported with the codec's words; NoSpace, Io.
  Result<void> append(Duration since_start);
  // Everything is in the file. level: what the pictures really held, of an HDR10 stream.
  Result<void> finish(const std::optional<LightLevel>& level);

 private:
  VideoWriter(std::unique_ptr<StorageFile> file, StorageStream::Direction direction)
      : stream_(std::move(file), direction), seekable_(direction == StorageStream::Direction::Write) {}

  Result<void> open_encoder(const VideoFormat& format);
  Result<void> write_header(const VideoFormat& format);
  Result<void> write_packets();
  Result<void> state_light_level(const LightLevel& level);
  Result<void> checked(int code, const char* what);

  StorageStream stream_;  // outlives the muxer
  const bool seekable_;
  libav::Muxer muxer_;
  libav::CodecContext encoder_;
  libav::Frame frame_;
  libav::Packet packet_;
  std::vector<std::uint8_t> header_;  // as it stands in the file
  std::optional<LightLevel> stated_;
  std::deque<std::int64_t> times_us_;             // of the pictures inside the encoder
  std::int64_t first_inside_ = 0, last_us_ = -1;  // number of the first of them
  std::int64_t longest_step_us_ = std::numeric_limits<std::int64_t>::max();  // that the container can state
  std::int64_t left_out_us_ = 0;                                             // of longer ones
  bool is_numbered_ = false;                                                 // the container has no times
  std::int64_t last_written_ = -1;  // time of the packet before, in ticks of the container
};

}  // namespace hdrcam
