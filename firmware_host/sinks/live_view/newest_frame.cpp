#include "firmware_host/sinks/live_view/newest_frame.h"

namespace hdrcam {

void NewestFrame::put(const EmittedFrame& frame) {
  std::size_t free = 0;
  {
    const std::lock_guard lock(mutex_);
    while (free == newest_ || free == read_) ++free;
  }
  ShownFrame& shown = frames_[free];
  shown.hdr.facts = frame.hdr.facts;
  shown.hdr.exposure = frame.hdr.exposure;
  shown.hdr.reference_exposure = frame.hdr.reference_exposure;
  shown.hdr.white = frame.hdr.white;
  shown.hdr.radiance.copy_from(frame.hdr.radiance);
  shown.hdr.sigma.copy_from(frame.hdr.sigma);
  shown.hdr.provenance.copy_from(frame.hdr.provenance);
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
