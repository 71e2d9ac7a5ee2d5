// Real-time scheduling of a thread that must act at given instants. Reentrant.
#pragma once

#include "hal/core/result.h"

namespace hdrcam {

// The calling thread runs before every thread that is not real-time (SCHED_FIFO, priority 50 or the most that
// is allowed). Where that is refused it stays as it is, except that its sleeps end without the kernel's usual
// slack of 50 us. Permission, with what to do.
Result<void> run_this_thread_in_realtime();

}  // namespace hdrcam
