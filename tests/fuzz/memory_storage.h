// A disk that holds one file, in memory and only to read: what a fuzzer made. Thread-bound.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/storage.h"

namespace hdrcam::fuzz {

class MemoryStorage : public Storage {
 public:
  // The bytes outlive the storage and the files it opens. Every path names the same file.
  explicit MemoryStorage(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  Result<std::unique_ptr<StorageFile>> open(const std::string&) override {
    return std::unique_ptr<StorageFile>(std::make_unique<File>(bytes_));
  }
  Result<std::unique_ptr<StorageFile>> create(const std::string& path, Creation) override {
    return read_only(path);
  }
  Result<void> rename(const std::string& from, const std::string&, Creation) override {
    return read_only(from);
  }
  Result<void> remove(const std::string& path) override { return read_only(path); }
  Result<void> make_directories(const std::string& path) override { return read_only(path); }
  Result<FileFacts> look_at(const std::string& path) override {
    return FileFacts{FileKind::Regular, 1, 1, bytes_.size(), path};
  }

 private:
  class File : public StorageFile {
   public:
    explicit File(std::span<const std::uint8_t> bytes) : bytes_(std::as_bytes(bytes)) {}
    Result<std::size_t> read_at(std::uint64_t offset, std::span<std::byte> into) override {
      if (offset >= bytes_.size()) return std::size_t{0};
      const std::size_t size = std::min<std::size_t>(into.size(), bytes_.size() - offset);
      std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), size, into.begin());
      return size;
    }
    Result<void> write_at(std::uint64_t, std::span<const std::byte>) override { return read_only("it"); }
    Result<std::uint64_t> size() override { return std::uint64_t{bytes_.size()}; }
    Result<void> sync() override { return {}; }

   private:
    std::span<const std::byte> bytes_;
  };

  static Error read_only(const std::string& path) {
    return {ErrorCode::Permission, "cannot write '" + path + "': a file in memory"};
  }

  std::span<const std::uint8_t> bytes_;
};

}  // namespace hdrcam::fuzz
