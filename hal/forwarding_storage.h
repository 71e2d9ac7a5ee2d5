// Another storage, for those that change some of its calls. It outlives this and the files it opens.
// Thread-safe as the other one is.
#pragma once

#include "hal/storage.h"

namespace hdrcam {

class ForwardingStorage : public Storage {
 public:
  explicit ForwardingStorage(Storage& inner) : inner_(inner) {}

  Result<std::unique_ptr<StorageFile>> open(const std::string& path) override { return inner_.open(path); }
  Result<std::unique_ptr<StorageFile>> create(const std::string& path,
                                              Creation how = Creation::Replace) override {
    return inner_.create(path, how);
  }
  Result<void> rename(const std::string& from, const std::string& to,
                      Creation how = Creation::Replace) override {
    return inner_.rename(from, to, how);
  }
  Result<void> remove(const std::string& path) override { return inner_.remove(path); }
  Result<void> make_directories(const std::string& path) override { return inner_.make_directories(path); }
  Result<FileFacts> look_at(const std::string& path) override { return inner_.look_at(path); }

 protected:
  Storage& inner_;
};

}  // namespace hdrcam
