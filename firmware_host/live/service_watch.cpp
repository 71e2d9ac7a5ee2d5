#include "firmware_host/live/service_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/core/thrown_by.h"

namespace hdrcam {
namespace {

constexpr Duration kStatusInterval = std::chrono::seconds(1);
constexpr int kLooksPerPatience = 10;  // so that a late thread does not look like a dead program

}  // namespace

bool SignOfLife::seen(const LiveCounters& now) {
  const bool captures = now.captured() != last_.captured();
  const bool fits = now.waiting() == 0 || now.taken != last_.taken;
  const bool records = now.to_record == 0 || now.recorded != last_.recorded;
  if (!captures || !fits || !records) return false;
  last_ = now;
  return true;
}

ServiceWatch::ServiceWatch(Supervisor supervisor, std::function<LiveCounters()> counters,
                           std::function<std::string(const LiveCounters&)> describe)
    : supervisor_(std::move(supervisor)), counters_(std::move(counters)), describe_(std::move(describe)) {
  if (supervisor_.present()) thread_ = std::thread([this] { watch(); });
}

ServiceWatch::~ServiceWatch() { stopping(); }

void ServiceWatch::stopping() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
  tell_stopping();
}

// In words of its own: of READY and STOPPING in one message the last one counts.
void ServiceWatch::tell_stopping() {
  if (!told_stopping_) told_stopping_ = supervisor_.tell("STOPPING=1");
}

void ServiceWatch::watch() {
  const Duration pause = supervisor_.patience() > Duration::zero()
                             ? std::min(kStatusInterval, supervisor_.patience() / kLooksPerPatience)
                             : kStatusInterval;
  Duration since_status = kStatusInterval;
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    lock.unlock();
    (void)thrown_by([&] { look(since_status >= kStatusInterval); });  // no memory for it: the next one may do
    since_status = since_status >= kStatusInterval ? pause : since_status + pause;
    lock.lock();
    wake_.wait_for(lock, pause, [this] { return stopping_; });
  }
}

void ServiceWatch::look(bool describe) {
  const LiveCounters now = counters_();
  const bool ready = ready_ || now.captured() > 0;
  std::string lines;
  if (ready && !ready_) lines += "READY=1\n";
  if (ready && life_.seen(now)) lines += "WATCHDOG=1\n";
  if (describe) lines += fmt::format("STATUS={}\n", describe_(now));
  if (!lines.empty() && supervisor_.tell(lines)) ready_ = ready;
  if (now.ended) tell_stopping();
}

}  // namespace hdrcam
