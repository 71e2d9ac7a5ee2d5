// Pictures and files that clients still read. Those who ask for one share its bytes, and only so many are
// held at once: clients that read slowly can not fill the memory. Thread-bound; what it hands out may be
// released on any thread.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
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
  // most_bytes: of all together, where more than one is held; files of a run are taken to be alike.
  explicit HeldFiles(std::size_t most, std::size_t most_bytes = std::numeric_limits<std::size_t>::max())
      : files_(most), most_bytes_(most_bytes) {}

  // The file that others read, else the one that `encode`, of type () -> Result<HttpBody>, makes. Errors:
  // Busy while as many others are read as are held at most, by number or by size; those of `encode`.
  template <class Encode>
  Result<HttpBody> share(const FileKey& key, const Encode& encode) {
    for (const File& file : files_)
      if (file.key == key)
        if (HttpBody body = file.body.lock()) return body;
    const Held held = count();  // first, for others may be released meanwhile
    const auto place = std::ranges::find_if(files_, [](const File& file) { return file.body.expired(); });
    if (place == files_.end() || (held.files > 0 && held.bytes + last_bytes_ > most_bytes_))
      return too_many(held.files);
    HttpBody body = TRY(encode());
    *place = {key, body};
    last_bytes_ = body->size();
    return body;
  }

 private:
  struct File {
    FileKey key;
    std::weak_ptr<const HttpBody::element_type> body = {};
  };

  struct Held {
    std::size_t files = 0, bytes = 0;
  };
  Held count() const {
    Held held;
    for (const File& file : files_)
      if (const HttpBody body = file.body.lock()) ++held.files, held.bytes += body->size();
    return held;
  }

  static Error too_many(std::size_t held) {
    return {ErrorCode::Busy,
            fmt::format("{} still being read; ask again",
                        held == 1 ? "an earlier frame is" : fmt::format("{} earlier frames are", held))};
  }

  std::vector<File> files_;
  const std::size_t most_bytes_;
  std::size_t last_bytes_ = 0;  // of the file made last
};

}  // namespace hdrcam
