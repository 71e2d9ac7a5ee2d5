#include "hal/core/thread_priority.h"

#include <sys/resource.h>

namespace hdrcam {

// On Linux the nice value belongs to the thread, and PRIO_PROCESS with 0 is the calling one (setpriority(2),
// "C library/kernel differences"). Weights fall by a factor of 1.25 per step.
void set_priority_of_this_thread(ThreadPriority priority) {
  constexpr int kTenfold = 10;
  if (priority == ThreadPriority::Background) (void)setpriority(PRIO_PROCESS, 0, kTenfold);
}

}  // namespace hdrcam
