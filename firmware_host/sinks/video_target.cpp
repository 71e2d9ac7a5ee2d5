#include "firmware_host/sinks/video_target.h"

namespace hdrcam {

Result<VideoTarget> VideoTarget::at(Storage& storage, const std::string& path) {
  return VideoTarget(storage, TRY(FileInMaking::beside_or_through(storage, path)));
}

Result<std::unique_ptr<VideoWriter>> VideoTarget::open(const VideoFormat& format) {
  using Direction = StorageStream::Direction;
  if (!making_) return VideoWriter::create(std::move(pipe_), Direction::Pipe, format);
  FileInMaking making = *std::move(making_);
  auto file = TRY(making.create());
  if (making.is_through()) return VideoWriter::create(std::move(file), Direction::Pipe, format);
  TRY(file->hold());
  auto writer = TRY(VideoWriter::create(std::move(file), Direction::Write, format));
  TRY(making.commit(Durability::WrittenBack, Forestalled::Goes));  // it has no frame yet
  named_ = making.real_path();
  return writer;
}

Result<void> VideoTarget::sync_name() const {
  return named_.empty() ? Result<void>() : hdrcam::sync_name(*storage_, named_);
}

}  // namespace hdrcam
