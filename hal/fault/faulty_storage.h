// A storage that fails on request: a full disk, a disk that refuses a write, a truncated file, a disk that
// flips bits. It wraps a real one, so that the files that the program leaves can be read back. For tests.
// Thread safety of the wrapped one, as long as one thread writes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/forwarding_storage.h"

namespace hdrcam {

struct StorageFaults {
  // The disk is full once files have grown by so much in all: NoSpace.
  std::optional<std::uint64_t> space_bytes = std::nullopt;
  // This write_at, counted from 0 over all files, is refused: Io.
  std::optional<std::uint64_t> failing_write = std::nullopt;
  std::optional<std::uint64_t> failing_read = std::nullopt;  // this read_at likewise
  std::optional<std::uint64_t> failing_sync = std::nullopt;  // this sync likewise
  std::optional<std::uint64_t> cut_at_bytes = std::nullopt;  // files opened to read end here
  // Of files opened to read, counted from the first bit of the file.
  std::vector<std::uint64_t> flipped_bits = {};
};

class FaultyStorage : public ForwardingStorage {
 public:
  // inner outlives this and the files it opens; so does this.
  FaultyStorage(Storage& inner, StorageFaults faults)
      : ForwardingStorage(inner), faults_(std::move(faults)) {}

  Result<std::unique_ptr<StorageFile>> open(const std::string& path) override;
  Result<std::unique_ptr<StorageFile>> create(const std::string& path,
                                              Creation how = Creation::Replace) override;

  // Calls so far, refused ones included.
  std::uint64_t reads() const { return reads_; }
  std::uint64_t writes() const { return writes_; }
  std::uint64_t syncs() const { return syncs_; }

 private:
  class File;

  StorageFaults faults_;
  std::uint64_t reads_ = 0, writes_ = 0, syncs_ = 0, used_bytes_ = 0;
};

}  // namespace hdrcam
