#include "hal/gpu/vulkan/pipeline_cache.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

namespace hdrcam::vulkan {
namespace {

struct Seal {
  char word[8] = {'h', 'd', 'r', 'c', 'g', 'p', 'u', '1'};
  std::uint64_t bytes = 0, checksum = 0;
};

// FNV-1a, 64 bits.
std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  std::uint64_t hash = 14695981039346656037u;
  for (const std::byte byte : bytes) hash = (hash ^ static_cast<std::uint64_t>(byte)) * 1099511628211u;
  return hash;
}

}  // namespace

std::string pipeline_cache_path(const std::string& folder, const std::string& device_uuid) {
  return folder.empty() ? "" : folder + "/kernels-" + device_uuid + ".bin";
}

std::vector<std::byte> read_pipeline_cache(Storage& storage, const std::string& path) {
  if (path.empty()) return {};
  const Result<std::string> file = read_whole(storage, path);
  Seal seal;
  if (!file || file.value().size() < sizeof seal) return {};
  const std::span<const std::byte> all = std::as_bytes(std::span(file.value()));
  const std::span<const std::byte> compiled = all.subspan(sizeof seal);
  std::memcpy(&seal, all.data(), sizeof seal);
  if (std::memcmp(seal.word, Seal().word, sizeof seal.word) != 0 || seal.bytes != compiled.size() ||
      seal.checksum != checksum_of(compiled))
    return {};
  return {compiled.begin(), compiled.end()};
}

Result<void> write_pipeline_cache(Storage& storage, const std::string& path,
                                  std::span<const std::byte> compiled) {
  TRY(storage.make_directories(std::filesystem::path(path).parent_path().string()));
  Seal seal;
  seal.bytes = compiled.size(), seal.checksum = checksum_of(compiled);
  std::vector<std::byte> file(sizeof seal + compiled.size());
  std::memcpy(file.data(), &seal, sizeof seal);
  std::copy(compiled.begin(), compiled.end(), file.begin() + sizeof seal);
  return write_whole(storage, path, file, Durability::WrittenBack);
}

}  // namespace hdrcam::vulkan
