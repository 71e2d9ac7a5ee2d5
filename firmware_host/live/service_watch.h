// Tells the service manager how a run on a camera goes (hal/supervisor.h): ready when the first frame is
// there, alive as long as every part of the run that has work makes progress, and how far it is, about once a
// second. On a thread of its own, which reads counters only: a capture, a disk or a fit that hangs stops the
// sign of life, and the service manager restarts the program. Once no further frame is captured the run
// stops: what the fit, the files and the recording still take is no hang. That it is ready and that it stops
// is said again where a busy service manager did not take it. Thread-bound.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "firmware_host/live/live_session.h"
#include "hal/supervisor.h"

namespace hdrcam {

// Decides whether a run is alive. Plain value.
class SignOfLife {
 public:
  // Whether capture, recorder and fit each got on since the last time the answer was yes; one without work
  // does not have to. The fit gets on by taking frames: it may keep some until later ones come.
  bool seen(const LiveCounters& now);

 private:
  LiveCounters last_;
};

class ServiceWatch {
 public:
  // counters: asked from the watch's thread until its end. describe: a line about them.
  ServiceWatch(Supervisor supervisor, std::function<LiveCounters()> counters,
               std::function<std::string(const LiveCounters&)> describe);
  ~ServiceWatch();

  // The run ends: from now on the service manager waits for the end, not for signs of life.
  void stopping();

 private:
  void watch();
  void look(bool describe);
  void tell_stopping();  // until it is taken, once

  const Supervisor supervisor_;
  const std::function<LiveCounters()> counters_;
  const std::function<std::string(const LiveCounters&)> describe_;
  SignOfLife life_;
  bool ready_ = false, told_stopping_ = false;  // and the supervisor took it
  std::mutex mutex_;                            // guards stopping_
  std::condition_variable wake_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace hdrcam
