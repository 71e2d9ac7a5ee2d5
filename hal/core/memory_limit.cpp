#include "hal/core/memory_limit.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace hdrcam {
namespace {

// Of the control group; "max", or a kernel without them: no limit of its own.
std::uint64_t group_limit() {
  std::uint64_t least = UINT64_MAX;
  for (const char* path : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::uint64_t bytes = 0;
    if (std::ifstream(path) >> bytes && bytes > 0) least = std::min(least, bytes);
  }
  return least;
}

}  // namespace

MemoryLimit MemoryLimit::share_of_machine() {
  const auto pages = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PHYS_PAGES)));
  const auto page_bytes = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PAGESIZE)));
  return MemoryLimit(std::min(pages * page_bytes, group_limit()) / 2);
}

Result<void> MemoryLimit::admit(const std::string& what, std::uint64_t bytes) const {
  if (bytes <= bytes_) return {};
  const auto mib = [](std::uint64_t value) { return (value + (1U << 20) - 1) >> 20; };
  return Error{ErrorCode::Unsupported,
               fmt::format("{} needs about {} MiB of memory, {} MiB are allowed; --memory {} allows it", what,
                           mib(bytes), mib(bytes_), mib(bytes))};
}

}  // namespace hdrcam
