// What runs when there is more to do than processors: the thread that serves a device before those that
// compute. Reentrant.
#pragma once

namespace hdrcam {

enum class ThreadPriority {
  Usual,
  Background,  // a tenth of the share of a usual thread, where both want to run
};

// Sets it for the calling thread and the threads it starts from now on. There is no way back without
// privileges.
void set_priority_of_this_thread(ThreadPriority priority);

}  // namespace hdrcam
