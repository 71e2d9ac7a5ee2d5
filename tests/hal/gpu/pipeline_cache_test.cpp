#include "hal/gpu/vulkan/pipeline_cache.h"

#include <filesystem>
#include <fstream>

#include "tests/support/scratch_folder.h"

#include "tests/contracts/expect.h"

namespace hdrcam::vulkan {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

TEST_CASE("compiled kernels are found again as they were kept") {
  const std::string path = pipeline_cache_path(test::scratch_folder("kernels") + "/deep", "0123");
  CHECK(read_pipeline_cache(posix_storage(), path).empty());
  require_done(write_pipeline_cache(posix_storage(), path, bytes_of("compiled")));
  CHECK(read_pipeline_cache(posix_storage(), path) == bytes_of("compiled"));
  require_done(write_pipeline_cache(posix_storage(), path, bytes_of("compiled anew")));
  CHECK(read_pipeline_cache(posix_storage(), path) == bytes_of("compiled anew"));
}

TEST_CASE("compiled kernels that were cut or changed count as none") {
  const std::string path = pipeline_cache_path(test::scratch_folder("damaged_kernels"), "0123");
  require_done(write_pipeline_cache(posix_storage(), path, bytes_of("compiled")));
  const auto whole = fs::file_size(path);
  for (std::uintmax_t size = 0; size < whole; ++size) {
    fs::resize_file(path, size);
    CHECK(read_pipeline_cache(posix_storage(), path).empty());
    require_done(write_pipeline_cache(posix_storage(), path, bytes_of("compiled")));
  }
  for (std::uintmax_t at = 0; at < whole; ++at) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(at));
    const char was = static_cast<char>(file.get());
    file.seekp(static_cast<std::streamoff>(at));
    file.put(static_cast<char>(was ^ 1));
    file.close();
    CHECK(read_pipeline_cache(posix_storage(), path).empty());
    require_done(write_pipeline_cache(posix_storage(), path, bytes_of("compiled")));
  }
}

TEST_CASE("without a folder no kernels are kept") {
  CHECK(pipeline_cache_path("", "0123").empty());
  CHECK(read_pipeline_cache(posix_storage(), "").empty());
}

}  // namespace
}  // namespace hdrcam::vulkan
