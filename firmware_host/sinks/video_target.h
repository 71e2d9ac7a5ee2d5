// Where a video goes: a file, or a pipe that is open already. A file is made with the first frame: a run
// without any leaves none, and an earlier video stays as it is. Thread-bound.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "hal/core/result.h"
#include "hal/storage.h"
#include "hal/video/video_writer.h"

namespace hdrcam {

class VideoTarget {
 public:
  explicit VideoTarget(std::unique_ptr<StorageFile> pipe) : pipe_(std::move(pipe)) {}
  // The storage outlives the target.
  VideoTarget(Storage& storage, std::string path, StorageStream::Direction direction)
      : storage_(&storage), path_(std::move(path)), direction_(direction) {}

  // Once. What the codec or the disk refuses leaves no file, and an earlier video as it is. Errors: those of
  // the storage and of the codec.
  Result<std::unique_ptr<VideoWriter>> open(const VideoFormat& format);

 private:
  std::unique_ptr<StorageFile> pipe_;
  Storage* storage_ = nullptr;  // null for a pipe that is open already
  std::string path_;
  StorageStream::Direction direction_ = StorageStream::Direction::Pipe;
};

}  // namespace hdrcam
