// Whether frames wait for the fit, for the governor. Plain value.
#pragma once

namespace hdrcam {

enum class Backlog {
  Unknown,   // nothing queues: a recording waits
  None,      // the next frame at most
  Waiting,   // a few: the fit was late, and catches up
  Lasting,   // a few, for long: it does not catch up by itself
  Pressing,  // so many that some will be shed, or were
};

}  // namespace hdrcam
