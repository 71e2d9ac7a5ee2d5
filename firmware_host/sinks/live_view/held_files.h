// Pictures and files that clients still read. Those who ask for one share its bytes, and only so many are
// held at once: clients that read slowly can not fill the memory. Thread-bound; what it hands out may be
// released on any thread.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "firmware_host/web/http_server.h"
#include "hal/core/result.h"

namespace hdrcam {

// What tells one file from another.
struct FileKey {
  std::uint64_t sequence = 0;  // of its frame
  double exposure_ev = 0;      // of a picture: brighter by so many stops

  friend bool operator==(const FileKey&, const FileKey&) = default;
};

class HeldFiles {
 public:
  explicit HeldFiles(std::size_t most) : files_(most) {}

  // The file that others read, else the one that `encode`, of type () -> Result<HttpBody>, makes. Errors:
  // Busy while as many others are read as are held at most; those of `encode`.
  template <class Encode>
  Result<HttpBody> share(const FileKey& key, const Encode& encode) {
    for (const File& file : files_)
      if (file.key == key)
        if (HttpBody body = file.body.lock()) return body;
    const auto place = std::ranges::find_if(files_, [](const File& file) { return file.body.expired(); });
    if (place == files_.end())
      return Error{ErrorCode::Busy,
                   fmt::format("{} earlier frames are still being read; ask again", files_.size())};
    HttpBody body = TRY(encode());
    *place = {key, body};
    return body;
  }

 private:
  struct File {
    FileKey key;
    std::weak_ptr<const HttpBody::element_type> body = {};
  };

  std::vector<File> files_;
};

}  // namespace hdrcam
