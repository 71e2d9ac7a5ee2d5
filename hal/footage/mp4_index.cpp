#include "hal/footage/mp4_index.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/core/big_endian.h"

namespace hdrcam {

// 4.2: a box begins with its size, which counts itself, in 32 bits, and its type. A size of 1 stands for one
// of 64 bits behind the type, 0 for all that follows.
Result<bool> is_index_cut(StorageFile& file) {
  constexpr int kMostBoxes = 1000;  // before the index; there are few
  const std::uint64_t file_bytes = TRY(file.size());
  std::uint64_t at = 0;
  for (int box = 0; box < kMostBoxes && at < file_bytes; ++box) {
    std::array<std::byte, 16> head{};
    TRY(file.read_at(at, head));
    const std::string_view type(reinterpret_cast<const char*>(head.data()) + 4, 4);
    const std::uint64_t short_size = big_endian(std::span(head).first(4));
    const std::uint64_t size = short_size == 1 ? big_endian(std::span(head).subspan(8)) : short_size;
    const bool reaches_beyond = size > file_bytes - at;
    if (type == "moov") return reaches_beyond;
    if (size == 0 || reaches_beyond) return false;
    at += size;
  }
  return false;
}

}  // namespace hdrcam
