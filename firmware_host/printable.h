// Text of others, names in files above all, for people: what would move the cursor of a terminal, change its
// colours or show text in another order than it has is shown as a number. Reentrant.
#pragma once

#include <string>
#include <string_view>

namespace hdrcam {

// Control characters (C0, DEL, and C1 in UTF-8), marks of direction and separators of lines (U+2028, U+202E
// ..) become \u001B; the rest stays. Of JSON and TOML, in whose strings alone they can be, the meaning stays.
std::string printable(std::string_view text);
// The same of several lines: their ends and tabs stay.
std::string printable_lines(std::string_view text);

}  // namespace hdrcam
