#include "hal/core/memory_limit.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace hdrcam {
namespace {

// Of a group, below `mounted`, and of those around it; "max": no limit of its own.
std::uint64_t least_limit(const std::string& mounted, std::string group, const char* file) {
  std::uint64_t least = UINT64_MAX;
  for (;;) {
    std::uint64_t bytes = 0;
    if (std::ifstream(mounted + group + "/" + file) >> bytes && bytes > 0) least = std::min(least, bytes);
    if (group.empty()) return least;
    group.resize(std::min(group.rfind('/'), group.size() - 1));
  }
}

// Of the control groups of this process: lines of "hierarchy:controllers:path", without controllers for
// version 2 (cgroups(7)). A kernel without them: no limit.
std::uint64_t group_limit(const std::string& root) {
  const std::string unified = root + "/sys/fs/cgroup", memory = unified + "/memory";
  constexpr const char *kMax = "memory.max", *kLimit = "memory.limit_in_bytes";
  std::uint64_t least = std::min(least_limit(unified, "", kMax), least_limit(memory, "", kLimit));
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1),
                      path = line.substr(second + 1);
    if (controllers.empty()) least = std::min(least, least_limit(unified, path, kMax));
    if (fmt::format(",{},", controllers).find(",memory,") != std::string::npos)
      least = std::min(least, least_limit(memory, path, kLimit));
  }
  return least;
}

}  // namespace

MemoryLimit MemoryLimit::share_of_machine(const std::string& root) {
  const auto pages = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PHYS_PAGES)));
  const auto page_bytes = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PAGESIZE)));
  return MemoryLimit(std::min(pages * page_bytes, group_limit(root)) / 2);
}

Result<void> MemoryLimit::admit(const std::string& what, std::uint64_t bytes) const {
  if (bytes <= bytes_) return {};
  const auto mib = [](std::uint64_t value) { return (value + (1U << 20) - 1) >> 20; };
  return Error{ErrorCode::Unsupported,
               fmt::format("{} needs about {} MiB of memory, {} MiB are allowed; --memory {} allows it", what,
                           mib(bytes), mib(bytes_), mib(bytes))};
}

}  // namespace hdrcam
