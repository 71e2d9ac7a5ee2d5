// A number with its sign: "+0.33", "-2.00". What is shown as zero is "+0.00", never "-0.00". Reentrant.
#pragma once

#include <fmt/format.h>

#include <string>

namespace hdrcam {

inline std::string signed_text(double value, int decimals) {
  std::string text = fmt::format("{:+.{}f}", value, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos) text.front() = '+';
  return text;
}

}  // namespace hdrcam
