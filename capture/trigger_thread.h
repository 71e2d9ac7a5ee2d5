// The thread that drives a trigger line, in real time where that is permitted. The trigger outlives it.
// Thread-bound.
#pragma once

#include <thread>

#include "capture/trigger.h"

namespace hdrcam {

class TriggerThread {
 public:
  explicit TriggerThread(Trigger& trigger);
  ~TriggerThread();  // when the pulse being driven has ended
  TriggerThread(const TriggerThread&) = delete;
  TriggerThread& operator=(const TriggerThread&) = delete;

  // Permission where it is not scheduled in real time, with what to do.
  const Result<void>& realtime() const { return realtime_; }

 private:
  Trigger& trigger_;
  Result<void> realtime_;
  std::thread thread_;
};

}  // namespace hdrcam
