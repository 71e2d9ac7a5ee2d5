// The known word nearest to a mistyped one, as a suggestion. Reentrant.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hdrcam {

// Edits between two words: insertions, deletions, substitutions and swaps of neighbours (optimal string
// alignment).
int edit_distance(std::string_view a, std::string_view b);

// The known word with the fewest edits; none where even that one differs in more than a third of its letters,
// and none for a number.
std::optional<std::string> nearest_word(std::string_view typed, std::span<const std::string> known);

// " (did you mean 'WORD'?)", or "" where nothing is near.
std::string did_you_mean(std::string_view typed, std::span<const std::string> known);

}  // namespace hdrcam
