#include "tests/contracts/storage_contract.h"
#include "hal/fault/faulty_storage.h"
#include "hal/storage.h"
#include "tests/support/scratch_folder.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("the disk keeps the storage contract") {
  keeps_storage_contract({"posix", posix_storage(), test::scratch_folder("storage")});
}

TEST_CASE("a faulty disk without a fault keeps the storage contract") {
  FaultyStorage storage(posix_storage(), {});
  keeps_storage_contract({"faulty", storage, test::scratch_folder("faulty_storage")});
}

}  // namespace
}  // namespace hdrcam
