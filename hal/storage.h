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

class Storage {
 public:
  virtual ~Storage() = default;
  virtual Result<std::unique_ptr<StorageFile>> open(
      const std::string& path) = 0;  // to read; NotFound, Permission
  virtual Result<std::unique_ptr<StorageFile>> create(
      const std::string& path) = 0;  // empty, to write; Permission
  virtual Result<void> rename(const std::string& from, const std::string& to) = 0;  // replaces `to`
  virtual Result<void> remove(const std::string& path) = 0;
  virtual Result<void> make_directories(const std::string& path) = 0;
};

// The file system of this machine.
Storage& posix_storage();

// Writes path whole or not at all: a temporary file beside it, then rename.
Result<void> write_whole(Storage& storage, const std::string& path, std::span<const std::byte> bytes);
Result<std::string> read_whole(Storage& storage, const std::string& path);

}  // namespace hdrcam
