#include <unistd.h>

#include <filesystem>

#include "hal/fault/faulty_storage.h"
#include "hal/storage.h"
#include "tests/contracts/storage_contract.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

struct TemporaryFolder {
  TemporaryFolder() {
    char path[] = "/tmp/hdrcam-storage-XXXXXX";
    REQUIRE(mkdtemp(path) != nullptr);
    name = path;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(name); }
  std::string name;
};

TEST_CASE("the disk keeps the storage contract") {
  const TemporaryFolder folder;
  keeps_storage_contract({"posix", posix_storage(), folder.name});
}

TEST_CASE("a faulty disk without a fault keeps the storage contract") {
  const TemporaryFolder folder;
  FaultyStorage storage(posix_storage(), {});
  keeps_storage_contract({"faulty", storage, folder.name});
}

}  // namespace
}  // namespace hdrcam
