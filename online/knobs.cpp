#include "online/knobs.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hal/core/parse_number.h"

namespace hdrcam {
namespace {

Result<const Knob*> find_knob(std::string_view name) {
  const auto table = knob_table();
  const auto found = std::find_if(table.begin(), table.end(), [&](const Knob& k) { return k.name == name; });
  if (found != table.end()) return &*found;
  std::vector<std::string_view> alike;
  for (const Knob& knob : table)
    if (!name.empty() && (knob.name.find(name) != std::string::npos || knob.name[0] == name[0]))
      alike.push_back(knob.name);
  if (alike.empty())
    for (const Knob& knob : table) alike.push_back(knob.name);
  return Error{ErrorCode::Invalid,
               fmt::format("there is no knob '{}'; there are {}", name, fmt::join(alike, ", "))};
}

// Such as 1000000000 and 0.00001.
std::string without_exponent(double limit) {
  std::string text = fmt::format("{:.9f}", limit);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

std::string accepted_values(const Knob& knob) {
  if (knob.kind == KnobKind::Choice)
    return fmt::format("{} or {}", fmt::join(knob.choices.begin(), knob.choices.end() - 1, ", "),
                       knob.choices.back());
  std::string text = fmt::format("{}, {}..{}", knob.kind == KnobKind::Whole ? "a whole number" : "a number",
                                 without_exponent(knob.least), without_exponent(knob.most));
  if (*knob.unit != '\0') text += fmt::format(" {}", knob.unit);
  if (knob.multiple > 1) text += fmt::format(", a multiple of {}", knob.multiple);
  return text;
}

Result<std::string> knob_value(const Knobs& knobs, std::string_view name) {
  const Knob& knob = *TRY(find_knob(name));
  const double value = knob.get(knobs);
  if (knob.kind == KnobKind::Choice) return knob.choices[static_cast<std::size_t>(value)];
  return fmt::format("{}", static_cast<float>(value));
}

Result<void> set_knob(Knobs& knobs, std::string_view name, std::string_view text) {
  const Knob& knob = *TRY(find_knob(name));
  const auto refuse = [&] {
    return Error{ErrorCode::Invalid,
                 fmt::format("{} takes {}, not '{}'", knob.name, accepted_values(knob), text)};
  };
  if (knob.kind == KnobKind::Choice) {
    const auto found = std::find(knob.choices.begin(), knob.choices.end(), text);
    if (found == knob.choices.end()) return refuse();
    knob.put(knobs, static_cast<double>(found - knob.choices.begin()));
    return {};
  }
  const auto value = parse_number<double>(text);
  if (!value || *value < knob.least || *value > knob.most) return refuse();
  if (knob.kind == KnobKind::Whole && std::fmod(*value, knob.multiple) != 0) return refuse();
  knob.put(knobs, *value);
  return {};
}

}  // namespace hdrcam
