#include "firmware_host/sinks/live_view/newest_frame.h"

namespace hdrcam {

void NewestFrame::put(const EmittedFrame& frame) {
  std::size_t free = 0;
  {
    const std::lock_guard lock(mutex_);
    while (free == newest_ || free == read_) ++free;
  }
  ShownFrame& shown = frames_[free];
  copy_picture(frame.hdr, shown.hdr);
  shown.record = frame.record;
  const std::lock_guard lock(mutex_);
  newest_ = free;
}

const ShownFrame* NewestFrame::read() {
  const std::lock_guard lock(mutex_);
  read_ = newest_;
  return read_ == kNone ? nullptr : &frames_[read_];
}

}  // namespace hdrcam
