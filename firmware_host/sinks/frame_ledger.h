// frames.csv, the list of the frames that left: number, time, exposure and its verdict, file. A live run
// sheds frames, and the names of the files alone do not say when they were taken. A line is on the disk once
// its frame is. Thread-bound.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hal/core/frame.h"
#include "hal/storage.h"

namespace hdrcam {

class FrameLedger {
 public:
  static constexpr const char* kFile = "frames.csv";

  // folder: of the frames; it exists. A ledger of an earlier run is replaced. Errors: those of the disk.
  static Result<FrameLedger> create(Storage& storage, const std::string& folder);

  // file: of the frame, without its folder. Errors: NoSpace, Io.
  Result<void> append(const FrameFacts& facts, const std::string& file);

 private:
  explicit FrameLedger(std::unique_ptr<StorageFile> file) : file_(std::move(file)) {}
  Result<void> write(const std::string& line);

  std::unique_ptr<StorageFile> file_;
  std::uint64_t bytes_ = 0;
};

}  // namespace hdrcam
