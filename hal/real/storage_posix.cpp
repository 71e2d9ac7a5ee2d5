// The file system behind Storage: every error of the kernel becomes a sentence with the path in it.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "hal/storage.h"

namespace hdrcam {
namespace {

Error error_of(int code, const std::string& what, const std::string& path) {
  const std::string reason = std::strerror(code);
  switch (code) {
    case ENOENT:
      return {ErrorCode::NotFound, fmt::format("'{}' does not exist", path), code};
    case EACCES:
    case EPERM:
    case EROFS:
    case EISDIR:
    case ENOTDIR:
      return {ErrorCode::Permission, fmt::format("cannot {} '{}': {}", what, path, reason), code};
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return {ErrorCode::NoSpace,
              fmt::format("no space left to {} '{}': {}; free some and run again", what, path, reason), code};
    default:
      return {ErrorCode::Io, fmt::format("cannot {} '{}': {}", what, path, reason), code};
  }
}

class PosixFile : public StorageFile {
 public:
  PosixFile(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}
  ~PosixFile() override { ::close(fd_); }

  Result<std::size_t> read_at(std::uint64_t offset, std::span<std::byte> bytes) override {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n =
          ::pread(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
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
      const ssize_t n =
          ::pwrite(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return error_of(errno, "write", path_);
      done += static_cast<std::size_t>(n);
    }
    return {};
  }

  Result<std::uint64_t> size() override {
    struct stat status {};
    if (::fstat(fd_, &status) != 0) return error_of(errno, "read", path_);
    if (S_ISDIR(status.st_mode)) return error_of(EISDIR, "read", path_);
    return static_cast<std::uint64_t>(status.st_size);
  }

  Result<void> sync() override {
    if (::fdatasync(fd_) != 0 && errno != EINVAL) return error_of(errno, "sync", path_);
    return {};
  }

 private:
  int fd_;
  std::string path_;
};

class PosixStorage : public Storage {
 public:
  Result<std::unique_ptr<StorageFile>> open(const std::string& path) override {
    return opened(path, O_RDONLY, "read");
  }
  Result<std::unique_ptr<StorageFile>> create(const std::string& path) override {
    return opened(path, O_RDWR | O_CREAT | O_TRUNC, "write");
  }
  Result<void> rename(const std::string& from, const std::string& to) override {
    if (std::rename(from.c_str(), to.c_str()) != 0) return error_of(errno, "write", to);
    return {};
  }
  Result<void> remove(const std::string& path) override {
    if (::unlink(path.c_str()) != 0) return error_of(errno, "remove", path);
    return {};
  }
  Result<void> make_directories(const std::string& path) override {
    std::error_code code;
    std::filesystem::create_directories(path, code);
    if (code) return error_of(code.value(), "create the folder", path);
    return {};
  }

 private:
  static Result<std::unique_ptr<StorageFile>> opened(const std::string& path, int flags, const char* what) {
    const int fd = ::open(path.c_str(), flags | O_CLOEXEC, 0644);
    if (fd < 0) {
      if (errno == ENOENT && (flags & O_CREAT) != 0)
        return Error{ErrorCode::Permission, fmt::format("cannot write '{}': its folder does not exist", path),
                     ENOENT};
      return error_of(errno, what, path);
    }
    return std::unique_ptr<StorageFile>(std::make_unique<PosixFile>(fd, path));
  }
};

}  // namespace

Storage& posix_storage() {
  static PosixStorage storage;
  return storage;
}

Result<void> write_whole(Storage& storage, const std::string& path, std::span<const std::byte> bytes) {
  const std::string temporary = path + ".part";
  const auto write = [&]() -> Result<void> {
    auto file = TRY(storage.create(temporary));
    return file->write_at(0, bytes);
  };
  if (auto written = write(); !written) {
    (void)storage.remove(temporary);
    return written;
  }
  return storage.rename(temporary, path);
}

Result<std::string> read_whole(Storage& storage, const std::string& path) {
  auto file = TRY(storage.open(path));
  std::string text(TRY(file->size()), '\0');
  const std::size_t n = TRY(file->read_at(0, std::as_writable_bytes(std::span(text))));
  text.resize(n);
  return text;
}

}  // namespace hdrcam
