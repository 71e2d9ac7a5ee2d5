#include "firmware_host/sinks/video_target.h"

namespace hdrcam {

Result<VideoTarget> VideoTarget::at(Storage& storage, const std::string& path) {
  VideoTarget target;
  if (TRY(storage.look_at(path)).kind == FileKind::Other)
    target.storage_ = &storage, target.path_ = path;
  else
    target.making_.emplace(TRY(FileInMaking::beside(storage, path)));
  return target;
}

Result<std::unique_ptr<VideoWriter>> VideoTarget::open(const VideoFormat& format) {
  using Direction = StorageStream::Direction;
  if (!making_)
    return VideoWriter::create(storage_ == nullptr ? std::move(pipe_) : TRY(storage_->create(path_)),
                               Direction::Pipe, format);
  FileInMaking making = *std::move(making_);
  auto file = TRY(making.create());
  TRY(file->hold());
  auto writer = TRY(VideoWriter::create(std::move(file), Direction::Write, format));
  TRY(making.commit(Durability::WrittenBack, Forestalled::Goes));  // it has no frame yet
  return writer;
}

}  // namespace hdrcam
