// Whether frames wait for the fit, for the governor. Plain value.
#pragma once

namespace hdrcam {

enum class Backlog {
  Unknown,   // nothing queues: a recording waits
  None,      // the next frame at most
  Waiting,   // a few: the fit was late, and catches up
  Pressing,  // many, or some were shed: it does not catch up by itself
};

}  // namespace hdrcam
