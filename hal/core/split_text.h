// A text cut at separators, after some characters, and without the blanks around it. The parts point into the
// text. Reentrant.
#pragma once

#include <string_view>
#include <vector>

namespace hdrcam {

// All parts, empty ones too: one more than there are separators.
inline std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(at);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// The same, but nothing behind a last separator, and no part of an empty text: "a,b," is two.
inline std::vector<std::string_view> split_list(std::string_view text, char at) {
  std::vector<std::string_view> parts = split(text, at);
  if (parts.back().empty()) parts.pop_back();
  return parts;
}

// Without these characters at both ends.
inline std::string_view trimmed(std::string_view text, std::string_view blanks = " \t") {
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

// The first characters of UTF-8, no more than so many bytes.
inline std::string_view first_characters(std::string_view text, std::size_t most_bytes) {
  const auto continues = [text](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xc0U) == 0x80U;
  };
  std::size_t end = most_bytes < text.size() ? most_bytes : text.size();
  while (end > 0 && end < text.size() && continues(end)) --end;
  return text.substr(0, end);
}

}  // namespace hdrcam
