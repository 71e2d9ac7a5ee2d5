// What is still to be done when this process dies, however it dies (SIGKILL, a crash): a child process waits
// for the end of a pipe, does it, and ends. It ignores the signals that end a group of processes. Where the
// object goes out of scope first, the act is not done. Thread-bound. Prepare it while the process has one
// thread: a child has only the thread that forked it.
#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <string>

#include "hal/core/result.h"
#include "hal/descriptor.h"

namespace hdrcam {

class LastAct {
 public:
  // name: of the child, as ps shows it. The act has no open files. Io.
  static Result<std::unique_ptr<LastAct>> prepare(const std::string& name, const std::function<void()>& act);
  ~LastAct();  // dismisses the child and waits for its end
  LastAct(const LastAct&) = delete;
  LastAct& operator=(const LastAct&) = delete;

 private:
  LastAct(pid_t child, Descriptor pipe) : child_(child), pipe_(std::move(pipe)) {}

  pid_t child_;
  Descriptor pipe_;  // a byte dismisses the child; its end without one is the death of this process
};

}  // namespace hdrcam
