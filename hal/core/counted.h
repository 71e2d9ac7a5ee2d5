// A number and what it counts, for messages: "1 frame", "12 frames". Reentrant.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace hdrcam {

template <class Number>
std::string counted(Number number, std::string_view thing) {
  return fmt::format("{} {}{}", number, thing, number == 1 ? "" : "s");
}

}  // namespace hdrcam
