// Text of others, names in files above all, for people: what would move the cursor of a terminal or change
// its colours is shown as a number. Reentrant.
#pragma once

#include <string>
#include <string_view>

namespace hdrcam {

// Control characters (C0, DEL, and C1 in UTF-8) become \u001B; the rest stays.
std::string printable(std::string_view text);

}  // namespace hdrcam
