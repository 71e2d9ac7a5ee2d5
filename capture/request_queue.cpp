#include "capture/request_queue.h"

namespace hdrcam {

Result<void> RequestQueue::fill(FrameMatcher& matcher, int most) {
  waiting_.reset();
  queued_ = 0;
  depth_ = most;
  TRY(top_up(matcher));
  depth_ = queued_;
  return {};
}

Result<bool> RequestQueue::top_up(FrameMatcher& matcher) {
  while (queued_ < depth_) {
    if (!waiting_) waiting_ = matcher.next_request();
    const Result<void> queued = camera_.queue(*waiting_);
    if (!queued && queued.error().code == ErrorCode::Busy) return false;
    if (!queued) return queued.error();
    if (clock_ != nullptr) matcher.queued(*waiting_, clock_->now());
    waiting_.reset();
    ++queued_;
  }
  return true;
}

}  // namespace hdrcam
