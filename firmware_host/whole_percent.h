// A share in whole percent, rounded down, so that 100 is shown only where it is all. Reentrant.
#pragma once

#include <cstdint>

namespace hdrcam {

// 0 of none.
constexpr std::uint64_t whole_percent(std::uint64_t part, std::uint64_t all) {
  return all > 0 ? 100 * part / all : 0;
}

}  // namespace hdrcam
