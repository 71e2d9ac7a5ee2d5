#include "firmware_host/sinks/video_target.h"

namespace hdrcam {

Result<std::unique_ptr<VideoWriter>> VideoTarget::open(const VideoFormat& format) {
  if (direction_ == StorageStream::Direction::Pipe)
    return VideoWriter::create(storage_ == nullptr ? std::move(pipe_) : TRY(storage_->create(path_)),
                               direction_, format);
  FileInMaking making = TRY(FileInMaking::beside(*storage_, path_));
  auto file = TRY(making.create());
  auto writer = TRY(VideoWriter::create(std::move(file), direction_, format));
  TRY(making.commit(Durability::WrittenBack));
  return writer;
}

}  // namespace hdrcam
