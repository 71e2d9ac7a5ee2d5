// The newest HDR frame, handed from the thread that emits to the one that shows. Neither waits for the other
// longer than an index takes: of three frames one is being written, one is the newest, one is being read.
// Thread-safe for one writer and one reader.
#pragma once

#include <array>
#include <cstddef>
#include <mutex>

#include "firmware_host/sinks/frame_sink.h"

namespace hdrcam {

struct ShownFrame {
  HdrFrame hdr;  // without depth and flow
  FrameRecord record;
};

class NewestFrame {
 public:
  void put(const EmittedFrame& frame);
  // Valid until the next call; null before the first frame.
  const ShownFrame* read();

 private:
  static constexpr std::size_t kNone = 3;

  std::array<ShownFrame, kNone> frames_;
  std::mutex mutex_;  // guards the members below
  std::size_t newest_ = kNone, read_ = kNone;
};

}  // namespace hdrcam
