#include "firmware_host/sinks/video_target.h"

namespace hdrcam {

Result<std::unique_ptr<VideoWriter>> VideoTarget::open(const VideoFormat& format) {
  auto file = storage_ == nullptr ? std::move(pipe_) : TRY(storage_->create(path_));
  auto writer = VideoWriter::create(std::move(file), direction_, format);
  if (!writer && direction_ == StorageStream::Direction::Write) (void)storage_->remove(path_);
  return writer;
}

}  // namespace hdrcam
