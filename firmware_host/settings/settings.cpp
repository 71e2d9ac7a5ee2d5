#include "firmware_host/settings/settings.h"

#include <algorithm>
#include <thread>

namespace hdrcam {

int thread_count(const Settings::Fit& fit) {
  return fit.threads > 0 ? fit.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

const std::string& Settings::Output::path(std::string_view sink) const {
  static const std::string none;
  const auto found = paths.find(sink);
  return found == paths.end() ? none : found->second;
}

}  // namespace hdrcam
