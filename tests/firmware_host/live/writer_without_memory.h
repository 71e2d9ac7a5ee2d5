// A recording whose frames take more memory than there is, from one of them on. Thread-bound.
#pragma once

#include <memory>
#include <new>
#include <utility>

#include "hal/recording/recording.h"

namespace hdrcam::test {

class WriterWithoutMemory : public RecordingWriter {
 public:
  // frames: that it writes before.
  WriterWithoutMemory(std::unique_ptr<RecordingWriter> inner, int frames)
      : inner_(std::move(inner)), frames_left_(frames) {}

  Result<void> append(const RawFrame& frame) override {
    if (frames_left_-- == 0) throw std::bad_alloc();
    return inner_->append(frame);
  }
  Result<void> finish() override { return inner_->finish(); }

 private:
  const std::unique_ptr<RecordingWriter> inner_;
  int frames_left_;
};

}  // namespace hdrcam::test
