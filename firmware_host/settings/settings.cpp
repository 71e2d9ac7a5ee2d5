#include "firmware_host/settings/settings.h"

#include <algorithm>
#include <thread>

namespace hdrcam {

int thread_count(const Settings::Fit& fit) {
  return fit.threads > 0 ? fit.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace hdrcam
