// The requirements of every Storage: the disk, a disk in memory, and the wrapper that injects faults while it
// injects none. See camera_contract.h.
#pragma once

#include <string>

#include "hal/storage.h"

namespace hdrcam {

struct StorageUnderTest {
  std::string name;
  Storage& storage;
  std::string folder;  // an empty one, to write in
};

void keeps_storage_contract(const StorageUnderTest& storage);

}  // namespace hdrcam
