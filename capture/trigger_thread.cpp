#include "capture/trigger_thread.h"

#include <future>

#include "hal/core/realtime.h"
#include "hal/core/thread_name.h"

namespace hdrcam {

TriggerThread::TriggerThread(Trigger& trigger) : trigger_(trigger) {
  std::promise<Result<void>> scheduled;
  auto realtime = scheduled.get_future();
  thread_ = std::thread([this, scheduled = std::move(scheduled)]() mutable {
    name_this_thread("trigger");
    scheduled.set_value(run_this_thread_in_realtime());
    trigger_.run();
  });
  realtime_ = realtime.get();
}

TriggerThread::~TriggerThread() {
  trigger_.end();
  thread_.join();
}

}  // namespace hdrcam
