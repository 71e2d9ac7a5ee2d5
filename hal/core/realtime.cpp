#include "hal/core/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstring>

namespace hdrcam {

Result<void> run_this_thread_in_realtime() {
  constexpr int kPriority = 50;
  constexpr unsigned long kLeastSlack_ns = 1;
  (void)::prctl(PR_SET_TIMERSLACK, kLeastSlack_ns, 0, 0, 0);
  rlimit allowed{};
  (void)::getrlimit(RLIMIT_RTPRIO, &allowed);
  const auto limit = static_cast<int>(std::min<rlim_t>(allowed.rlim_cur, kPriority));
  int refused = 0;
  for (const int priority : {kPriority, limit}) {
    if (priority < 1) continue;
    const sched_param wanted{priority};
    refused = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted);
    if (refused == 0) return {};
  }
  return Error{ErrorCode::Permission,
               fmt::format("real-time scheduling is not permitted ({}); allow it with 'ulimit -r {}', or "
                           "LimitRTPRIO={} in a service",
                           std::strerror(refused), kPriority, kPriority),
               refused};
}

}  // namespace hdrcam
