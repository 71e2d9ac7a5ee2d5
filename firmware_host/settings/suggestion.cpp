#include "firmware_host/settings/suggestion.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace hdrcam {

int edit_distance(std::string_view a, std::string_view b) {
  // Three rows of the table: the row above the current one, and the one above that (for swaps).
  std::vector<int> two_above, above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int substitution = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, substitution});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], two_above[j - 2] + 1);
    }
    two_above = above;
    std::swap(above, row);
  }
  return above[b.size()];
}

namespace {

// Other names of what we know, which are no typing errors of it.
std::optional<std::string> other_name_of(std::string_view typed, std::span<const std::string> known) {
  constexpr std::pair<std::string_view, std::string_view> kNames[] = {
      {"h265", "hevc"}, {"x265", "hevc"}, {"avc", "h264"}, {"x264", "h264"},
      {"hdr10", "pq"},  {"st2084", "pq"}, {"hdr", "pq"},   {"gpu", "vulkan"}};
  for (const auto& [other, ours] : kNames)
    if (typed == other && std::ranges::find(known, ours) != known.end()) return std::string(ours);
  return std::nullopt;
}

// 55 is no typing error of 50: a digit more or less is another value.
bool is_number(std::string_view typed) {
  return typed.find_first_not_of("0123456789.,-+") == std::string_view::npos;
}

}  // namespace

std::optional<std::string> nearest_word(std::string_view typed, std::span<const std::string> known) {
  if (is_number(typed)) return std::nullopt;
  if (auto ours = other_name_of(typed, known)) return ours;
  std::optional<std::string> nearest;
  int fewest = 0;
  for (const std::string& word : known) {
    const int edits = edit_distance(typed, word);
    const int allowed = std::max<int>(1, static_cast<int>(word.size()) / 3);
    if (edits > allowed || (nearest && edits >= fewest)) continue;
    nearest = word;
    fewest = edits;
  }
  return nearest;
}

std::string did_you_mean(std::string_view typed, std::span<const std::string> known) {
  const auto word = nearest_word(typed, known);
  return word ? fmt::format(" (did you mean '{}'?)", *word) : "";
}

}  // namespace hdrcam
