// Presents a file of the storage as the byte stream that libavformat reads and writes. The library reports a
// disk failure as a number, sometimes only at the next call; the storage's own first Error is kept here.
// Thread-bound.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "hal/recording/libav.h"
#include "hal/storage.h"

namespace hdrcam {

class StorageStream {
 public:
  enum class Direction {
    Read,
    Write,
    Pipe,  // write, in order, without going back
  };

  StorageStream(std::unique_ptr<StorageFile> file, Direction direction);
  ~StorageStream();
  StorageStream(const StorageStream&) = delete;
  StorageStream& operator=(const StorageStream&) = delete;

  AVIOContext* context() { return context_; }  // owned by the stream
  StorageFile& file() { return *file_; }
  const std::optional<Error>& failure() const { return failure_; }

 private:
  static int read(void* self, std::uint8_t* bytes, int size);
  static int write(void* self, libav::Written* bytes, int size);
  static std::int64_t seek(void* self, std::int64_t offset, int whence);
  template <class T>
  int failed(const Result<T>& result);

  std::unique_ptr<StorageFile> file_;
  std::uint64_t offset_ = 0;
  std::optional<Error> failure_;
  AVIOContext* context_ = nullptr;
};

}  // namespace hdrcam
