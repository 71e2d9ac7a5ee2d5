#include "firmware_host/run/backend.h"

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <string_view>

namespace hdrcam {
namespace {

// "": nowhere.
std::string cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/')
    return std::string(cache) + "/hdrcam";
  const char* home = std::getenv("HOME");
  return home != nullptr && *home == '/' ? std::string(home) + "/.cache/hdrcam" : "";
}

}  // namespace

Backend open_backend(const std::string& asked) {
  if (asked == "cpu") return {};
  constexpr std::string_view kNamed = "vulkan:";
  GpuOptions options;
  if (asked.starts_with(kNamed)) options.name = asked.substr(kNamed.size());
  options.cache_folder = cache_folder();
  auto gpu = open_gpu(options);
  if (!gpu) {
    spdlog::warn("--backend {}: {}; computing on the processor", asked, gpu.error().message);
    return {nullptr, fmt::format("computed on the processor, not with {}: {}", asked, gpu.error().message)};
  }
  std::string note = fmt::format("computed with {}: {}", asked, (*gpu)->facts().name);
  return {std::move(*gpu), std::move(note)};
}

}  // namespace hdrcam
