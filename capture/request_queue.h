// Keeps a camera supplied with capture requests: as many are queued as it has buffers for. A request that was
// made and finds no free buffer is not lost; it is the next one. Thread-bound; no allocation.
#pragma once

#include <optional>

#include "capture/frame_matcher.h"
#include "hal/camera.h"

namespace hdrcam {

class RequestQueue {
 public:
  // The camera outlives it.
  explicit RequestQueue(Camera& camera) : camera_(camera) {}

  // The camera has just started: nothing is queued. Queues up to `most` requests of the matcher; from now on
  // as many as the device took, which may have fewer buffers. Errors: the camera's own.
  Result<void> fill(FrameMatcher& matcher, int most);
  // A buffer completed a request.
  void completed() { --queued_; }
  // Queues requests of the matcher until the camera has as many as it takes. False where no buffer was free
  // for one, which waits for the next call. Errors: the camera's own.
  Result<bool> top_up(FrameMatcher& matcher);

 private:
  Camera& camera_;
  std::optional<ExposureRequest> waiting_;  // made, but the camera had no free buffer yet
  int queued_ = 0, depth_ = 0;              // queued requests now, and at most
};

}  // namespace hdrcam
