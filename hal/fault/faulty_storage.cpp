#include "hal/fault/faulty_storage.h"

#include <algorithm>
#include <cerrno>

namespace hdrcam {

class FaultyStorage::File : public StorageFile {
 public:
  File(FaultyStorage& disk, std::unique_ptr<StorageFile> inner, std::string path, bool written)
      : disk_(disk), inner_(std::move(inner)), path_(std::move(path)), written_(written) {}

  Result<void> hold() override { return inner_->hold(); }

  Result<std::size_t> read_at(std::uint64_t offset, std::span<std::byte> bytes) override {
    if (disk_.reads_++ == disk_.faults_.failing_read) return refused("read");
    const std::uint64_t end = TRY(size());
    if (offset >= end) return std::size_t{0};
    bytes = bytes.first(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), end - offset)));
    const std::size_t done = TRY(inner_->read_at(offset, bytes));
    if (!written_) flip(offset, bytes.first(done));
    return done;
  }

  // A full disk writes as much as fits, as the kernel does.
  Result<void> write_at(std::uint64_t offset, std::span<const std::byte> bytes) override {
    if (disk_.writes_++ == disk_.faults_.failing_write) return refused("write");
    const std::uint64_t end = TRY(inner_->size());
    const std::uint64_t growth = offset + bytes.size() > end ? offset + bytes.size() - end : 0;
    const std::uint64_t room =
        disk_.faults_.space_bytes ? *disk_.faults_.space_bytes - disk_.used_bytes_ : growth;
    const std::uint64_t lost = growth > room ? growth - room : 0;
    disk_.used_bytes_ += growth - lost;
    if (lost < bytes.size())
      TRY(inner_->write_at(offset, bytes.first(bytes.size() - static_cast<std::size_t>(lost))));
    if (lost == 0) return {};
    return Error{ErrorCode::NoSpace,
                 fmt::format("no space left to write '{}'; free some and run again", path_), ENOSPC};
  }

  Result<std::uint64_t> size() override {
    const std::uint64_t inner = TRY(inner_->size());
    return written_ ? inner : std::min(inner, disk_.faults_.cut_at_bytes.value_or(inner));
  }

  Result<void> sync() override {
    if (disk_.syncs_++ == disk_.faults_.failing_sync) return refused("sync");
    return inner_->sync();
  }

 private:
  Error refused(const char* what) const {
    return {ErrorCode::Io, fmt::format("cannot {} '{}': the disk refused", what, path_), EIO};
  }

  void flip(std::uint64_t offset, std::span<std::byte> bytes) const {
    for (const std::uint64_t bit : disk_.faults_.flipped_bits)
      if (bit / 8 >= offset && bit / 8 - offset < bytes.size())
        bytes[static_cast<std::size_t>(bit / 8 - offset)] ^= std::byte{1} << (bit % 8);
  }

  FaultyStorage& disk_;
  std::unique_ptr<StorageFile> inner_;
  std::string path_;
  bool written_;
};

Result<std::unique_ptr<StorageFile>> FaultyStorage::open(const std::string& path) {
  return std::unique_ptr<StorageFile>(std::make_unique<File>(*this, TRY(inner_.open(path)), path, false));
}

Result<std::unique_ptr<StorageFile>> FaultyStorage::create(const std::string& path, Creation how) {
  return std::unique_ptr<StorageFile>(
      std::make_unique<File>(*this, TRY(inner_.create(path, how)), path, true));
}

}  // namespace hdrcam
