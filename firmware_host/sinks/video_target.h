// Where a video goes: a file, or a pipe that is open already. A file is made with the first frame: a run
// without any leaves none, and an earlier video stays as it is. What another program wrote since the target
// was named is never replaced, nor what it still writes. Thread-bound.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hal/core/result.h"
#include "hal/storage.h"
#include "hal/video/video_writer.h"

namespace hdrcam {

class VideoTarget {
 public:
  explicit VideoTarget(std::unique_ptr<StorageFile> pipe) : pipe_(std::move(pipe)) {}
  // A regular file, or a FIFO or a device, which is written through. The storage outlives the target. Errors:
  // those of the storage.
  static Result<VideoTarget> at(Storage& storage, const std::string& path);

  // Once. What the codec or the disk refuses leaves no file, and an earlier video as it is; so does Exists,
  // where another program has written one meanwhile. Errors: those of the storage and of the codec.
  Result<std::unique_ptr<VideoWriter>> open(const VideoFormat& format);
  // Returns once the name of a file that was opened survives a power cut.
  Result<void> sync_name() const;

 private:
  VideoTarget(Storage& storage, FileInMaking making) : making_(std::move(making)), storage_(&storage) {}

  std::unique_ptr<StorageFile> pipe_;  // that is open already, or
  std::optional<FileInMaking> making_;
  Storage* storage_ = nullptr;
  std::string named_;  // the file that was opened; "" for none
};

}  // namespace hdrcam
