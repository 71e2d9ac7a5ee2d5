// "-" in the place of an output's name: the standard output, which takes frames and nothing else. Reentrant.
#pragma once

#include <fmt/format.h>

#include <string_view>

#include "hal/core/result.h"

namespace hdrcam {

inline constexpr std::string_view kStandardOutput = "-";

// Of an output that does not go there. Invalid.
inline Error not_to_standard_output(std::string_view flag) {
  return {ErrorCode::Invalid,
          fmt::format("{} - would write a file named '-': only HDR frames go to the standard output; name a "
                      "file",
                      flag)};
}

}  // namespace hdrcam
