// The files of frames that clients still read. Those who ask for one frame share its bytes, and no more than
// kMost frames are held at once: clients that read slowly can not fill the memory. Thread-bound; what it
// hands out may be released on any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>

#include "firmware_host/web/http_server.h"

namespace hdrcam {

class HeldFiles {
 public:
  static constexpr std::size_t kMost = 4;

  // Null where nobody reads that frame.
  HttpBody of(std::uint64_t sequence) const {
    for (const File& file : files_)
      if (file.sequence == sequence)
        if (HttpBody body = file.body.lock()) return body;
    return nullptr;
  }
  bool full() const { return free_place() == files_.end(); }
  // Not while full.
  void hold(std::uint64_t sequence, const HttpBody& body) {
    const auto place = free_place() - files_.begin();
    files_[static_cast<std::size_t>(place)] = {sequence, body};
  }

 private:
  struct File {
    std::uint64_t sequence = 0;
    std::weak_ptr<const HttpBody::element_type> body = {};
  };
  using Files = std::array<File, kMost>;
  Files::const_iterator free_place() const {
    return std::ranges::find_if(files_, [](const File& file) { return file.body.expired(); });
  }

  Files files_;
};

}  // namespace hdrcam
