// The recordings that a person starts while a camera runs (--http-record takes/%03d.mkv): each is a new file
// with the next number that none has, and at the end a line says how many frames it got. Thread-bound.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware_host/sinks/frame_pattern.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/recording/recording.h"
#include "hal/storage.h"

namespace hdrcam {

class Takes {
 public:
  // The storage outlives the takes.
  Takes(Storage& storage, FramePattern names, RecordingCodec codec)
      : storage_(storage), names_(std::move(names)), codec_(codec) {}

  struct Created {
    std::string path;
    std::unique_ptr<RecordingWriter> writer;
  };
  // Also makes their folder. Errors: those of the disk.
  Result<Created> create(const CameraFacts& camera);
  // No frame went into this one, nor will: its file goes.
  void discard(const std::string& path) { (void)storage_.remove(path); }
  // Frames go into this one from now on. frames: in all takes before it, which are complete.
  void started(std::string path, std::uint64_t frames) { started_.push_back({std::move(path), frames}); }

  // The error that cut the last one, with how its frames become a complete recording. frames: in all takes.
  Error cut(Error error, std::uint64_t frames) const;

  // Those that were started, each with its frames, a line each. frames: in all of them.
  std::string account(std::uint64_t frames) const;

 private:
  struct Started {
    std::string path;
    std::uint64_t before = 0;  // frames in the takes before it
  };

  Storage& storage_;
  const FramePattern names_;
  const RecordingCodec codec_;
  std::uint64_t next_ = 1;
  std::vector<Started> started_;
};

}  // namespace hdrcam
