// One video or picture file, decoded by the FFmpeg libraries: frame after frame, its codes as RGB or mono
// (decoded_codes.h), upright. What is damaged is left out and counted. Thread-bound.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/footage/decoded_codes.h"
#include "hal/footage/picture_file.h"
#include "hal/recording/libav.h"
#include "hal/recording/storage_stream.h"

namespace hdrcam {

class VideoFile : public PictureFile {
 public:
  // Errors: NotFound, Permission; NotRecording where FFmpeg finds no picture in it; Truncated for an MP4 that
  // ends within its index; Unsupported for a codec that this machine's libraries lack.
  static Result<std::unique_ptr<PictureFile>> open(Storage& storage, const std::string& path);

  const PictureFileFacts& facts() const override { return facts_; }
  // Beyond what PictureFile says: Unsupported for interlaced video, floating point, a colour space without
  // RGB, TIFF in tiles or with JPEG inside.
  Result<bool> next(RawFrame& frame) override;
  std::optional<ExifTime> taken() const override;
  ExifFactors factors() const override;
  PictureLosses losses() const override { return losses_; }

 private:
  VideoFile(std::unique_ptr<StorageFile> file, std::string path)
      : stream_(std::move(file), StorageStream::Direction::Read), path_(std::move(path)) {}

  Result<void> open_decoder();
  Result<void> check_index();
  Result<bool> decode();
  Result<void> feed();
  Result<void> check_codes(const AVPacket& packet) const;
  void send(const AVPacket& packet);
  bool is_whole();
  void lose_until_key();
  bool ends_inside_frame();
  int missing_at_end();
  Result<void> begin_codes();
  void take_orientation();
  Error refused(ErrorCode code, const std::string& why) const;

  StorageStream stream_;  // outlives the demuxer
  const std::string path_;
  libav::Demuxer demuxer_;
  libav::CodecContext decoder_;
  libav::Frame frame_;
  libav::Packet packet_;
  int track_ = 0;
  bool still_ = false;
  Orientation in_packet_ = Orientation::Upright;  // the latest

  PictureLosses losses_;
  bool awaits_key_frame_ = false, awaits_key_packet_ = false;  // what comes before it lacks what it refers to
  int packets_ = 0;                                            // of the track
  std::int64_t end_ = 0;                                       // of the latest of them, in ticks of the track
  std::int64_t end_byte_ = 0;  // of the latest of them in the file, or of the file's head

  PictureFileFacts facts_;
  DecodedCodes codes_;
};

}  // namespace hdrcam
