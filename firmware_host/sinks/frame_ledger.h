// frames.csv, the list of the frames that left (docs/stats.md): number, time since the first frame and on the
// sensor's clock, exposure and its verdict, file. A live run sheds frames, and the names of the files alone
// do not say when they were taken. What stands before the number of the frames' names stands before that of
// the list, so that takes in one folder have one each. A line is written once its frame is; a power cut may
// lose both, as long as the system has not written them back. Thread-bound.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "firmware_host/sinks/frame_pattern.h"
#include "hal/core/frame.h"
#include "hal/storage.h"

namespace hdrcam {

class FrameLedger {
 public:
  static std::string path_beside(const FramePattern& frames);
  // By its name.
  static bool is_one(const std::string& path);

  // The folder of the frames exists. A ledger of an earlier run is replaced by take_name() or with the first
  // line, so that a run that never had a frame leaves it. Errors: those of the disk.
  static Result<FrameLedger> create(Storage& storage, const FramePattern& frames);

  // To be called once the first frame is whole and before it has its own name: of two runs with the same
  // names the later one then replaces no frame of the other. Errors: those of FileInMaking::commit.
  Result<void> take_name();

  // time_s: since the first frame. file: of the frame, without its folder. Errors: NoSpace, Io.
  Result<void> append(const FrameFacts& facts, double time_s, const std::string& file);

 private:
  FrameLedger(FileInMaking making, std::unique_ptr<StorageFile> file)
      : making_(std::move(making)), file_(std::move(file)) {}
  Result<void> write(const std::string& line);

  FileInMaking making_;
  std::unique_ptr<StorageFile> file_;
  bool named_ = false;  // the file has its name
  std::uint64_t bytes_ = 0;
};

}  // namespace hdrcam
