#include "firmware_host/printable.h"

#include <fmt/format.h>

namespace hdrcam {

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto code = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0U;
    if (code < 0x20 || code == 0x7f) {
      out += fmt::format("\\u{:04X}", code);
    } else if (code == 0xc2 && next >= 0x80 && next < 0xa0) {
      out += fmt::format("\\u{:04X}", next);
      ++i;
    } else {
      out += text[i];
    }
  }
  return out;
}

}  // namespace hdrcam
