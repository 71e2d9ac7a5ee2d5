// The disk. Everything the program writes or reads goes through this seam, so that a full disk, a failing
// disk and a power cut can be tested. Thread-safe: distinct files may be used from distinct threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/core/result.h"

namespace hdrcam {

class StorageFile {
 public:
  virtual ~StorageFile() = default;
  // Reads up to bytes.size() at the offset; returns how many there were (0 at the end).
  virtual Result<std::size_t> read_at(std::uint64_t offset, std::span<std::byte> bytes) = 0;
  virtual Result<void> write_at(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
  virtual Result<std::uint64_t> size() = 0;
  virtual Result<void> sync() = 0;  // returns when the bytes would survive a power cut
};

// What stands under a path, symbolic links followed.
enum class FileKind {
  Missing,  // nothing, but a file could be made there
  Regular,
  Folder,
  Other,  // a device, a FIFO, a socket: may be written through, never replaced
};
struct FileFacts {
  FileKind kind = FileKind::Missing;
  std::uint64_t device = 0, inode = 0;  // the same file has the same two, whatever its names
  std::uint64_t size_bytes = 0;
  std::string real_path;  // without symbolic links; of a missing file, where it would be made
};

// What happens to a file that is there already.
enum class Creation {
  Replace,  // it is emptied; a device or a FIFO is written through
  New,      // Exists; a symbolic link counts as there, wherever it points
};

class Storage {
 public:
  virtual ~Storage() = default;
  virtual Result<std::unique_ptr<StorageFile>> open(
      const std::string& path) = 0;  // to read; NotFound, Permission
  virtual Result<std::unique_ptr<StorageFile>> create(
      const std::string& path, Creation how = Creation::Replace) = 0;  // empty, to write; Permission, Exists
  // Replaces `to`, whose permissions stay.
  virtual Result<void> rename(const std::string& from, const std::string& to) = 0;
  virtual Result<void> remove(const std::string& path) = 0;
  virtual Result<void> make_directories(const std::string& path) = 0;
  virtual Result<FileFacts> look_at(const std::string& path) = 0;  // Permission, Io
};

// The file system of this machine.
Storage& posix_storage();

// A file that has its name only once it is whole. Until then it stands beside `path` under a name that nobody
// can guess or prepare; what was under `path` stays until commit(). A symbolic link stays a link.
// Thread-bound.
class FileInMaking {
 public:
  // Errors: those of Storage::look_at; Permission where `path` is no regular file.
  static Result<FileInMaking> beside(Storage& storage, const std::string& path);
  FileInMaking(FileInMaking&& other) noexcept;
  FileInMaking& operator=(FileInMaking&&) = delete;
  ~FileInMaking();  // removes what was not committed

  // To be created with Creation::New and closed before commit().
  const std::string& path() const { return path_; }
  Result<void> commit();

 private:
  FileInMaking(Storage& storage, std::string path, std::string final_path)
      : storage_(&storage), path_(std::move(path)), final_path_(std::move(final_path)) {}

  Storage* storage_;
  std::string path_, final_path_;
  bool ours_ = true;
};

// Writes path whole or not at all (FileInMaking). A device or a FIFO is written through.
Result<void> write_whole(Storage& storage, const std::string& path, std::span<const std::byte> bytes);
Result<std::string> read_whole(Storage& storage, const std::string& path);

}  // namespace hdrcam
