// The disk. Everything the program writes or reads goes through this seam, so that a full disk, a failing
// disk and a power cut can be tested. Thread-safe: distinct files may be used from distinct threads.
#pragma once

#include <atomic>
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
  // Returns once the bytes survive a power cut; NotFound where the file was removed.
  virtual Result<void> sync() = 0;
  // Keeps every FileInMaking from taking the file's name while it is open, in any program. Busy where another
  // open file holds it; a file system without locks holds nothing.
  virtual Result<void> hold() { return {}; }
};

// The kind of file at a path; symbolic links are followed.
enum class FileKind {
  Missing,  // no file, but one could be created there
  Regular,
  Folder,
  Other,  // a device, a FIFO, a socket: may be written to, never read or replaced
};
struct FileFacts {
  FileKind kind = FileKind::Missing;
  std::uint64_t device = 0, inode = 0;  // identify the file, whatever its names
  std::uint64_t size_bytes = 0;
  std::string real_path;  // symbolic links resolved; of a missing file, where it would be created
};
// Whatever their names and their contents. Missing files are one where they would be created at the same
// path.
bool same_file(const FileFacts& a, const FileFacts& b);

// What happens to an existing file.
enum class Creation {
  Replace,  // it is emptied; a device is written to, and a FIFO once a program reads it
  New,      // Exists; a symbolic link counts as existing, wherever it points
};

class Storage {
 public:
  virtual ~Storage() = default;
  // To read, a folder only to sync its names; NotFound, Permission (also for a device or a FIFO).
  virtual Result<std::unique_ptr<StorageFile>> open(const std::string& path) = 0;
  virtual Result<std::unique_ptr<StorageFile>> create(
      const std::string& path, Creation how = Creation::Replace) = 0;  // empty, to write; Permission, Exists
  // Replaces `to`, whose permissions stay; or Exists. A file system that cannot do New in one step does
  // Replace.
  virtual Result<void> rename(const std::string& from, const std::string& to,
                              Creation how = Creation::Replace) = 0;
  virtual Result<void> remove(const std::string& path) = 0;
  // With those above it; the names of new ones survive a power cut (sync_name).
  virtual Result<void> make_directories(const std::string& path) = 0;
  virtual Result<FileFacts> look_at(const std::string& path) = 0;  // Permission, Io
};

// The file system of this machine.
Storage& posix_storage();
// The same; `stop` ends the wait for a program that reads a FIFO (Interrupted), and outlives the storage.
std::unique_ptr<Storage> stoppable_posix_storage(const std::atomic<bool>& stop);

// Whether anything is at the path; false also where it cannot be told.
bool is_there(Storage& storage, const std::string& path);

// Whether a file that is complete survives a power cut at once, or only when the system has written it back,
// in some seconds: until then its name may stand for nothing.
enum class Durability { AtOnce, WrittenBack };
// What becomes of a new file where another program was first with that name: it stays beside that one, or
// goes, as nothing is in it yet that anybody would miss.
enum class Forestalled { Stays, Goes };

// Returns once the name of the file at `real_path` (FileFacts) survives a power cut: the name is the
// folder's, and of a file alone the disk may have the bytes and not yet the name (fsync(2)). Nothing where
// the folder may not be read, or its file system does not sync folders. Errors: those of a disk that fails or
// is full.
Result<void> sync_name(Storage& storage, const std::string& real_path);

// A file that gets its name only once it is complete. Until then it is beside `path` under an
// unpredictable name; an existing file at `path` stays until commit(). A symbolic link stays a link. What
// another program wrote to `path` meanwhile is never replaced. Thread-bound.
class FileInMaking {
 public:
  // Errors: those of Storage::look_at; Permission where `path` is no regular file.
  static Result<FileInMaking> beside(Storage& storage, const std::string& path);
  // The same; a device or a FIFO is written through: create() opens it, and commit() has nothing to do.
  static Result<FileInMaking> beside_or_through(Storage& storage, const std::string& path);
  FileInMaking(FileInMaking&& other) noexcept;
  FileInMaking& operator=(FileInMaking&&) = delete;
  ~FileInMaking();  // removes what was not committed

  bool is_through() const { return earlier_.kind == FileKind::Other; }
  // To be created with Creation::New.
  const std::string& path() const { return names_.making; }
  // The final path, its links resolved.
  const std::string& real_path() const { return earlier_.real_path; }
  // That file, empty, to write; its errors name the one that was asked for, before and after commit().
  Result<std::unique_ptr<StorageFile>> create() const;
  // Busy while another program holds the earlier file. Exists where another program has written one
  // meanwhile: that one stays, and so does this one under path() unless it goes.
  Result<void> commit(Durability durability = Durability::AtOnce,
                      Forestalled forestalled = Forestalled::Stays);

  // The outcome of work on path(). Nobody asked for that file: an error names the one that was asked for.
  template <class T>
  Result<T> as_asked(Result<T> outcome) const {
    return names_.as_asked(std::move(outcome));
  }

 private:
  class File;
  struct Names {
    std::string making, asked;  // asked: the final path as it was given, with its links

    template <class T>
    Result<T> as_asked(Result<T> outcome) const {
      if (outcome.ok()) return outcome;
      Error error = outcome.error();
      if (const std::size_t at = error.message.find(making); at != std::string::npos)
        error.message.replace(at, making.size(), asked);
      return error;
    }
  };

  FileInMaking(Storage& storage, std::string path, FileFacts earlier, std::string asked)
      : storage_(&storage),
        names_{std::move(path), std::move(asked)},
        earlier_(std::move(earlier)),
        ours_(!is_through()) {}
  Result<void> check_earlier(Forestalled forestalled);
  Error written_meanwhile(Forestalled forestalled);

  Storage* storage_;
  Names names_;
  FileFacts earlier_;  // what is at the final path, which is its real_path
  bool ours_;
};

// Writes the whole file or nothing (FileInMaking). A device or a FIFO is written to directly. Pictures of a
// stream are too many to wait for the disk with each.
Result<void> write_whole(Storage& storage, const std::string& path, std::span<const std::byte> bytes,
                         Durability durability = Durability::AtOnce);
// Reads a picture or a document. Unsupported beyond 2 GiB: it is neither, and might take all memory.
Result<std::string> read_whole(Storage& storage, const std::string& path);

}  // namespace hdrcam
