#include "firmware_host/printable.h"

#include <fmt/format.h>

#include <algorithm>

namespace hdrcam {
namespace {

// Control characters, what turns the direction of text, and the separators of lines and paragraphs.
bool is_unseen(unsigned code_point) {
  constexpr struct {
    unsigned first, last;
  } kRanges[] = {{0x00, 0x1f},     {0x7f, 0x9f},     {0x061c, 0x061c},
                 {0x200e, 0x200f}, {0x2028, 0x202e}, {0x2066, 0x2069}};
  return std::ranges::any_of(kRanges, [code_point](const auto& range) {
    return range.first <= code_point && code_point <= range.last;
  });
}

struct Utf8Character {
  unsigned code_point;
  std::size_t bytes;
};

// The first character of a text, of those that is_unseen() asks for, which have one to three bytes. Any other
// byte stands for itself.
Utf8Character first_of(std::string_view text) {
  constexpr unsigned kNoControl = 0xfffd;
  const auto byte = [text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const auto continues = [&](std::size_t i) { return (byte(i) & 0xc0u) == 0x80; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  if ((lead & 0xe0u) == 0xc0 && continues(1)) return {(lead & 0x1fu) << 6 | (byte(1) & 0x3fu), 2};
  if ((lead & 0xf0u) == 0xe0 && continues(1) && continues(2))
    return {(lead & 0x0fu) << 12 | (byte(1) & 0x3fu) << 6 | (byte(2) & 0x3fu), 3};
  return {kNoControl, 1};
}

std::string with_escapes(std::string_view text, std::string_view kept) {
  std::string out;
  while (!text.empty()) {
    const Utf8Character first = first_of(text);
    if (is_unseen(first.code_point) && kept.find(text.front()) == std::string_view::npos)
      out += fmt::format("\\u{:04X}", first.code_point);
    else
      out += text.substr(0, first.bytes);
    text.remove_prefix(first.bytes);
  }
  return out;
}

}  // namespace

std::string printable(std::string_view text) { return with_escapes(text, ""); }

std::string printable_lines(std::string_view text) { return with_escapes(text, "\n\t"); }

}  // namespace hdrcam
