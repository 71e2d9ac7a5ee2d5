// Keeps a camera supplied with capture requests: as many are queued as it has buffers for. A request that was
// made and finds no free buffer is not lost; it is the next one. Thread-bound; no allocation.
#pragma once

#include <optional>

#include "capture/frame_matcher.h"
#include "hal/camera.h"
#include "hal/clock.h"

namespace hdrcam {

class RequestQueue {
 public:
  // Camera and clock outlive it. clock: by which the matcher learns when requests are queued; null: it does
  // not.
  explicit RequestQueue(Camera& camera, Clock* clock = nullptr) : camera_(camera), clock_(clock) {}

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
  Clock* clock_;
  std::optional<ExposureRequest> waiting_;  // made, but the camera had no free buffer yet
  int queued_ = 0, depth_ = 0;              // queued requests now, and at most
};

}  // namespace hdrcam
