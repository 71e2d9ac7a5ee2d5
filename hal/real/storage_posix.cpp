// The file system behind Storage: every error of the kernel becomes a sentence with the path in it.
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include "hal/descriptor.h"
#include "hal/standard_output.h"
#include "hal/storage.h"

namespace hdrcam {
namespace {

// The part of a path that is a file where a folder is needed.
std::string file_within(const std::string& path) {
  std::filesystem::path part;
  for (const std::filesystem::path& name : std::filesystem::path(path)) {
    part /= name;
    std::error_code ignored;
    if (std::filesystem::exists(part, ignored) && !std::filesystem::is_directory(part, ignored)) break;
  }
  return part.string();
}

// The standard output is no file, so its name stands without quotes.
constexpr std::string_view kStandardOutputName = "the standard output";

std::string named(const std::string& path) {
  return path == kStandardOutputName ? path : fmt::format("'{}'", path);
}

Error error_of(int code, const std::string& what, const std::string& path) {
  const std::string reason = code == EBADF ? "it is closed" : std::strerror(code);
  switch (code) {
    case ENOENT:
      return {ErrorCode::NotFound, fmt::format("'{}' does not exist", path), code};
    case EEXIST:
      return {ErrorCode::Exists, fmt::format("'{}' exists already", path), code};
    case EACCES:
    case EPERM:
    case EROFS:
      return {ErrorCode::Permission, fmt::format("cannot {} {}: {}", what, named(path), reason), code};
    case EISDIR:
      return {ErrorCode::Permission, fmt::format("cannot {} '{}': it is a folder; name a file", what, path),
              code};
    case EPIPE:
      return {ErrorCode::Io, fmt::format("the program that reads {} has ended", named(path)), code};
    case ENOTDIR:
      return {ErrorCode::Permission,
              fmt::format("cannot {} '{}': '{}' is a file, and a folder is needed in its place", what, path,
                          file_within(path)),
              code};
    case ENOSPC:
    case EDQUOT:
      return {ErrorCode::NoSpace,
              fmt::format("no space left to {} {}: {}; free some and run again", what, named(path), reason),
              code};
    case EFBIG:
      return {ErrorCode::NoSpace,
              fmt::format("{} is as large as a file can be here (FAT: 4 GB, or 'ulimit -f'); write several "
                          "shorter ones, to another file system, or raise that limit",
                          named(path)),
              code};
    default:
      return {ErrorCode::Io, fmt::format("cannot {} {}: {}", what, named(path), reason), code};
  }
}

FileKind kind_of(const struct stat& status) {
  if (S_ISREG(status.st_mode)) return FileKind::Regular;
  return S_ISDIR(status.st_mode) ? FileKind::Folder : FileKind::Other;
}

// Resolves a symbolic link to a file that does not exist yet, which the standard library does not.
std::filesystem::path end_of_links(std::filesystem::path path) {
  constexpr int kMostLinks = 40;  // as many as the kernel follows
  std::error_code ignored;
  for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(path, ignored); ++i)
    path = path.parent_path() / std::filesystem::read_symlink(path, ignored);
  return path;
}

// Of a folder and those above it the ones that are not there, from the outermost on.
std::vector<std::string> missing_folders(const std::string& path) {
  std::vector<std::string> missing;
  std::error_code ignored;
  for (std::filesystem::path folder = std::filesystem::absolute(path, ignored);
       folder.has_relative_path() && !std::filesystem::exists(folder, ignored) && !ignored;
       folder = folder.parent_path())
    missing.push_back(folder.string());
  std::ranges::reverse(missing);
  return missing;
}

class PosixFile : public StorageFile {
 public:
  // What is kept of a file's place: the offset that each call names, or where a stream has come to.
  enum class Access { ByOffset, Stream };

  PosixFile(Descriptor fd, std::string path, Access access = Access::ByOffset)
      : fd_(std::move(fd)), path_(std::move(path)), streams_(access == Access::Stream) {}

  Result<std::size_t> read_at(std::uint64_t offset, std::span<std::byte> bytes) override {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n =
          ::pread(fd_.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return error_of(errno, "read", path_);
      if (n == 0) break;
      done += static_cast<std::size_t>(n);
    }
    return done;
  }

  Result<void> write_at(std::uint64_t offset, std::span<const std::byte> bytes) override {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n = write_some(offset + done, bytes.subspan(done));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && errno == EAGAIN) {
        wait_for_room();
        continue;
      }
      if (n < 0) return error_of(errno, "write", path_);
      done += static_cast<std::size_t>(n);
    }
    return {};
  }

  Result<std::uint64_t> size() override {
    struct stat status {};
    if (::fstat(fd_.get(), &status) != 0) return error_of(errno, "read", path_);
    if (S_ISDIR(status.st_mode)) return error_of(EISDIR, "read", path_);
    return static_cast<std::uint64_t>(status.st_size);
  }

  Result<void> sync() override {
    while (::fdatasync(fd_.get()) != 0) {
      if (errno == EINVAL) break;  // what cannot be synced, such as a folder of some file systems
      if (errno != EINTR) return error_of(errno, "sync", path_);
    }
    struct stat status {};
    if (::fstat(fd_.get(), &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 0)
      return Error{ErrorCode::NotFound,
                   fmt::format("'{}' was removed while it was written; its content is lost", path_)};
    return {};
  }

  Result<void> hold() override {
    if (::flock(fd_.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return {};
    return Error{
        ErrorCode::Busy,
        fmt::format("'{}' is being written by another program; wait until it ends, or name another file",
                    path_)};
  }

 private:
  // A FIFO or a terminal has no offsets: bytes are written in order.
  ssize_t write_some(std::uint64_t offset, std::span<const std::byte> bytes) {
    if (!streams_) {
      const ssize_t n = ::pwrite(fd_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (n >= 0 || errno != ESPIPE) return n;
      streams_ = true;
    }
    if (offset != streamed_) return errno = ESPIPE, -1;
    const ssize_t n = ::write(fd_.get(), bytes.data(), bytes.size());
    if (n > 0) streamed_ += static_cast<std::uint64_t>(n);
    return n;
  }

  // Whoever started the program may have given it a pipe or a terminal that does not block.
  void wait_for_room() const {
    pollfd full{fd_.get(), POLLOUT, 0};
    (void)::poll(&full, 1, -1);
  }

  const Descriptor fd_;
  std::string path_;
  bool streams_;  // also once a file shows that it has no offsets
  std::uint64_t streamed_ = 0;
};

class PosixStorage : public Storage {
 public:
  explicit PosixStorage(const std::atomic<bool>& stop) : stop_(stop) {}

  // A FIFO would be waited for, and neither it nor a device has the offsets and the size to be read by.
  Result<std::unique_ptr<StorageFile>> open(const std::string& path) override {
    struct stat there {};
    if (::stat(path.c_str(), &there) == 0 && kind_of(there) == FileKind::Other)
      return Error{ErrorCode::Permission,
                   fmt::format("cannot read '{}': it is a device or a FIFO; name a regular file", path)};
    return opened(path, O_RDONLY, "read");
  }
  Result<std::unique_ptr<StorageFile>> create(const std::string& path, Creation how) override {
    if (how == Creation::New) return opened(path, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW, "write");
    struct stat there {};
    if (::stat(path.c_str(), &there) == 0 && kind_of(there) == FileKind::Other)
      return S_ISFIFO(there.st_mode) ? opened_fifo(path) : opened(path, O_WRONLY, "write");
    return opened(path, O_RDWR | O_CREAT | O_TRUNC, "write");
  }
  Result<void> rename(const std::string& from, const std::string& to, Creation how) override {
    if (how == Creation::New) {
      if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return {};
      if (errno != EINVAL && errno != ENOSYS)
        return error_of(errno, "write", to);  // both: not on this one (NFS)
    }
    // of a file system with one owner for all its files (FAT, CIFS) nobody else may set even what is there
    constexpr mode_t kPermissions = 07777;
    struct stat replaced {};
    struct stat made {};
    if (::stat(to.c_str(), &replaced) == 0 && ::stat(from.c_str(), &made) == 0 &&
        ((replaced.st_mode ^ made.st_mode) & kPermissions) != 0 &&
        ::chmod(from.c_str(), replaced.st_mode & kPermissions) != 0)
      return error_of(errno, "write", to);
    if (std::rename(from.c_str(), to.c_str()) != 0) return error_of(errno, "write", to);
    return {};
  }
  Result<void> remove(const std::string& path) override {
    if (::unlink(path.c_str()) != 0) return error_of(errno, "remove", path);
    return {};
  }
  Result<void> make_directories(const std::string& path) override {
    const std::vector<std::string> missing = missing_folders(path);
    std::error_code code;
    std::filesystem::create_directories(path, code);
    if (code.value() == EEXIST)
      return Error{
          ErrorCode::NotFound,
          fmt::format("cannot create the folder '{}': it is, or lies behind, a link to a folder that "
                      "is not there; make that one, or mount its disk",
                      path),
          EEXIST};
    if (code) return error_of(code.value(), "create the folder", path);
    for (const std::string& folder : missing) TRY(sync_name(*this, folder));
    return {};
  }
  Result<FileFacts> look_at(const std::string& path) override {
    FileFacts facts;
    std::error_code code;
    // absolute first: a missing file in the current folder would keep the relative name it was given
    const std::filesystem::path absolute = std::filesystem::absolute(end_of_links(path), code);
    if (code.value() == ENOENT)  // no path from here leads anywhere
      return Error{ErrorCode::Io, "the current folder was removed; change to one that is there", ENOENT};
    if (!code) facts.real_path = std::filesystem::weakly_canonical(absolute, code).string();
    if (code) return error_of(code.value(), "look at", path);
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) {
      if (errno == ENOENT) return facts;
      return error_of(errno, "look at", path);
    }
    facts.kind = kind_of(status);
    facts.device = status.st_dev, facts.inode = status.st_ino;
    facts.size_bytes = static_cast<std::uint64_t>(status.st_size);
    return facts;
  }

 private:
  static Result<std::unique_ptr<StorageFile>> opened(const std::string& path, int flags, const char* what) {
    Descriptor fd(::open(path.c_str(), flags | O_CLOEXEC, 0666));
    if (!fd.is_open()) {
      if (errno == ENOENT && (flags & O_CREAT) != 0) {
        std::error_code ignored;
        const bool there =
            std::filesystem::exists(std::filesystem::absolute(path, ignored).parent_path(), ignored);
        return Error{ErrorCode::Permission,
                     fmt::format("cannot write '{}': its folder {}", path,
                                 there ? "takes no new files" : "does not exist"),
                     ENOENT};
      }
      return error_of(errno, what, path);
    }
    return std::unique_ptr<StorageFile>(std::make_unique<PosixFile>(std::move(fd), path));
  }

  // Once a program reads it; opened to read as well it would be its own reader. The kernel's own wait would
  // not end with a clean stop, so it is asked again and again.
  Result<std::unique_ptr<StorageFile>> opened_fifo(const std::string& path) const {
    constexpr std::chrono::milliseconds kBetweenTries{20};
    for (;;) {
      Descriptor fd(::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
      if (fd.is_open()) {
        if (::fcntl(fd.get(), F_SETFL, 0) != 0) return error_of(errno, "write", path);  // writes do wait
        return std::unique_ptr<StorageFile>(std::make_unique<PosixFile>(std::move(fd), path));
      }
      if (errno != ENXIO) return error_of(errno, "write", path);
      if (stop_)
        return Error{ErrorCode::Interrupted,
                     fmt::format("stopped while no program read the FIFO '{}'; start one that reads it, and "
                                 "run again",
                                 path)};
      std::this_thread::sleep_for(kBetweenTries);
    }
  }

  const std::atomic<bool>& stop_;
};

}  // namespace

std::unique_ptr<StorageFile> standard_output() {
  return std::make_unique<PosixFile>(Descriptor(::dup(STDOUT_FILENO)), std::string(kStandardOutputName),
                                     PosixFile::Access::Stream);
}

Storage& posix_storage() {
  static constinit const std::atomic<bool> never{false};
  static PosixStorage storage(never);
  return storage;
}

std::unique_ptr<Storage> stoppable_posix_storage(const std::atomic<bool>& stop) {
  return std::make_unique<PosixStorage>(stop);
}

}  // namespace hdrcam
