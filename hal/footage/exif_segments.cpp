#include "hal/footage/exif_segments.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

namespace hdrcam {

void hide_later_exif(std::span<std::uint8_t> jpeg) {
  constexpr std::uint8_t kMark = 0xff, kApp1 = 0xe1, kScan = 0xda;
  constexpr std::size_t kHeadBytes = 4;  // the mark, its kind and the length of what follows, with itself
  constexpr std::string_view kExif = "Exif";
  bool has_exif = false;
  for (std::size_t at = 0; at + kHeadBytes + kExif.size() <= jpeg.size();) {
    const std::uint8_t kind = jpeg[at + 1];
    if (jpeg[at] == kMark && kind == kScan) return;
    const std::size_t length = static_cast<std::size_t>(jpeg[at + 2]) << 8 | jpeg[at + 3];
    const bool is_segment =
        jpeg[at] == kMark && kind >= 0xc0 && kind != kMark && (kind < 0xd0 || kind > 0xd9);
    if (is_segment && kind == kApp1 && std::ranges::equal(jpeg.subspan(at + kHeadBytes, kExif.size()), kExif))
      if (std::exchange(has_exif, true)) jpeg[at + kHeadBytes] = 0;
    at += is_segment ? 2 + length : 1;
  }
}

}  // namespace hdrcam
