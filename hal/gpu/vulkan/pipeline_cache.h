// Compiled kernels between two starts of the program: a file per device and driver, sealed with its length
// and a checksum, because drivers trust what they are given. A file that is missing, cut or changed counts as
// empty; one that cannot be written is left out, as it only saves time. Thread-bound.
#pragma once

#include <string>
#include <vector>

#include "hal/storage.h"

namespace hdrcam::vulkan {

// "" where there is no folder.
std::string pipeline_cache_path(const std::string& folder, const std::string& device_uuid);
std::vector<std::byte> read_pipeline_cache(Storage& storage, const std::string& path);
Result<void> write_pipeline_cache(Storage& storage, const std::string& path,
                                  std::span<const std::byte> compiled);

}  // namespace hdrcam::vulkan
