#include "hal/recording/storage_stream.h"

#include <cerrno>
#include <cstdio>
#include <new>
#include <span>

namespace hdrcam {
namespace {

constexpr int kBufferBytes = 1 << 16;

}  // namespace

StorageStream::StorageStream(std::unique_ptr<StorageFile> file, Direction direction)
    : file_(std::move(file)) {
  const bool writes = direction != Direction::Read;
  auto* buffer = static_cast<unsigned char*>(libav::allocated(av_malloc(kBufferBytes)));
  context_ = avio_alloc_context(buffer, kBufferBytes, writes ? 1 : 0, this, writes ? nullptr : &read,
                                writes ? &write : nullptr, direction == Direction::Pipe ? nullptr : &seek);
  if (context_ == nullptr) {
    av_free(buffer);
    throw std::bad_alloc();
  }
}

StorageStream::~StorageStream() {
  av_freep(&context_->buffer);
  avio_context_free(&context_);
}

template <class T>
int StorageStream::failed(const Result<T>& result) {
  if (!failure_) failure_ = result.error();
  return AVERROR(EIO);
}

int StorageStream::read(void* self, std::uint8_t* bytes, int size) {
  auto& stream = *static_cast<StorageStream*>(self);
  const auto done = stream.file_->read_at(
      stream.offset_, std::as_writable_bytes(std::span(bytes, static_cast<std::size_t>(size))));
  if (!done) return stream.failed(done);
  if (done.value() == 0) return AVERROR_EOF;
  stream.offset_ += done.value();
  return static_cast<int>(done.value());
}

int StorageStream::write(void* self, libav::Written* bytes, int size) {
  auto& stream = *static_cast<StorageStream*>(self);
  if (stream.failure_) return AVERROR(EIO);  // data after a failed write must not look like a whole cluster
  const auto done =
      stream.file_->write_at(stream.offset_, std::as_bytes(std::span(bytes, static_cast<std::size_t>(size))));
  if (!done) return stream.failed(done);
  stream.offset_ += static_cast<std::uint64_t>(size);
  return size;
}

std::int64_t StorageStream::seek(void* self, std::int64_t offset, int whence) {
  auto& stream = *static_cast<StorageStream*>(self);
  whence &= ~AVSEEK_FORCE;
  if (whence == AVSEEK_SIZE || whence == SEEK_END) {
    const auto size = stream.file_->size();
    if (!size) return stream.failed(size);
    if (whence == AVSEEK_SIZE) return static_cast<std::int64_t>(size.value());
    offset += static_cast<std::int64_t>(size.value());
  } else if (whence == SEEK_CUR) {
    offset += static_cast<std::int64_t>(stream.offset_);
  }
  if (offset < 0) return AVERROR(EINVAL);
  stream.offset_ = static_cast<std::uint64_t>(offset);
  return offset;
}

}  // namespace hdrcam
