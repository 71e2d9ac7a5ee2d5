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

// "1 frame per second", "29.97 frames per second".
inline std::string counted_per_second(double rate_hz, std::string_view thing) {
  const std::string rate = fmt::format("{:.4g}", rate_hz);
  return fmt::format("{} {}{} per second", rate, thing, rate == "1" ? "" : "s");
}

}  // namespace hdrcam
