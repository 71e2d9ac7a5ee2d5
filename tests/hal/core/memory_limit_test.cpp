#include "hal/core/memory_limit.h"

#include <sys/sysinfo.h>

#include <filesystem>
#include <fstream>

#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr std::uint64_t kMiB = 1 << 20;

// A machine in a folder: the groups of this process, and files of limits below /sys/fs/cgroup.
std::string machine(const std::string& groups,
                    const std::vector<std::pair<std::string, std::string>>& limits) {
  const std::string root = sample::scratch_folder("memory_limit");
  std::filesystem::create_directories(root + "/proc/self");
  std::ofstream(root + "/proc/self/cgroup") << groups;
  for (const auto& [file, limit] : limits) {
    const std::filesystem::path path = root + "/sys/fs/cgroup/" + file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << limit << "\n";
  }
  return root;
}

std::uint64_t share_of(const std::string& root) { return MemoryLimit::share_of_machine(root).bytes() / kMiB; }

std::string mib(int count) { return std::to_string(static_cast<std::uint64_t>(count) * kMiB); }

}  // namespace

TEST_CASE("the memory of a service is what its own control group and those around it allow") {
  const std::string service = "system.slice/hdrcam.service/memory.max", slice = "system.slice/memory.max";
  const std::string two = "0::/system.slice/hdrcam.service\n";
  CHECK(share_of(machine(two, {{service, mib(200)}, {slice, "max"}})) == 100);
  CHECK(share_of(machine(two, {{service, "max"}, {slice, mib(100)}})) == 50);
  CHECK(share_of(machine(two, {{service, mib(200)}, {slice, mib(300)}})) == 100);
  CHECK(share_of(machine(two, {{service, "max"}, {"memory.max", mib(80)}})) == 40);  // a container's
  CHECK(share_of(machine("0::/\n", {{"memory.max", mib(60)}, {service, mib(10)}})) == 30);
}

TEST_CASE("the memory of a control group of version 1 is that of its own hierarchy") {
  const std::string unlimited = "9223372036854771712";
  const std::string one = "4:cpu,memory:/a/b\n3:cpuset:/c\n0::/\n";
  CHECK(share_of(machine(one, {{"memory/a/b/memory.limit_in_bytes", mib(200)},
                               {"memory/a/memory.limit_in_bytes", unlimited},
                               {"memory/c/memory.limit_in_bytes", mib(2)}})) == 100);
  CHECK(share_of(machine(one, {{"memory/a/b/memory.limit_in_bytes", unlimited},
                               {"memory/memory.limit_in_bytes", mib(50)}})) == 25);
}

TEST_CASE("without control groups the memory is half of the machine's") {
  struct sysinfo system {};
  REQUIRE(::sysinfo(&system) == 0);
  const std::uint64_t all = share_of(machine("", {}));
  CHECK(all == std::uint64_t{system.totalram} * system.mem_unit / 2 / kMiB);
  CHECK(share_of(machine("garbage\n0:\n", {})) == all);
  CHECK(share_of(machine("0::/a\n", {{"a/memory.max", "max"}})) == all);
}
