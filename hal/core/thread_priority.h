// Scheduling when threads outnumber processors: a thread that serves a device runs before threads that
// compute. Reentrant.
#pragma once

namespace hdrcam {

enum class ThreadPriority {
  Usual,
  Background,  // a tenth of the processor share of a usual thread, where both are ready to run
};

// Sets it for the calling thread and the threads that it starts later. Raising it again needs privileges.
void set_priority_of_this_thread(ThreadPriority priority);

}  // namespace hdrcam
