// A time as a user writes it where seconds are usual: 90, 90s, 0.5 or 100ms, of any length. Reentrant.
#pragma once

#include <optional>
#include <string_view>

#include "capture/exposure.h"
#include "hal/core/parse_number.h"

namespace hdrcam {

inline std::optional<double> seconds_of(std::string_view text) {
  if (const auto duration = parse_duration(text)) return to_seconds(duration.value());
  if (text.ends_with('s')) text.remove_suffix(1);
  return parse_number<double>(text);
}

}  // namespace hdrcam
