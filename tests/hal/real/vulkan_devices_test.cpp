#include "hal/real/vulkan_devices.h"

#include <algorithm>
#include <cctype>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

TEST_CASE("graphics devices have a name, a kind and a version, or it is said what to install") {
  const auto found = vulkan_devices();
  if (!found) {
    CHECK((found.error().code == ErrorCode::NotFound || found.error().code == ErrorCode::Unsupported));
    CHECK(found.error().message.find("install") != std::string::npos);
    return;
  }
  for (const VulkanDevice& device : found.value()) {
    CHECK_FALSE(device.name.empty());
    CHECK_FALSE(device.kind.empty());
    CHECK(std::count(device.api.begin(), device.api.end(), '.') == 2);
    CHECK(std::isdigit(static_cast<unsigned char>(device.api.front())));
    CHECK(device.memory_gib >= 0);
  }
}

}  // namespace
}  // namespace hdrcam
