#include "firmware_host/settings/setting_field.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "capture/exposure.h"
#include "firmware_host/settings/suggestion.h"
#include "hal/core/parse_number.h"
#include "hal/core/split_text.h"
#include "render/white_balance.h"

namespace hdrcam {
namespace {

bool is_number(const SettingField& field) {
  return field.type == SettingType::Whole || field.type == SettingType::Real;
}
bool is_switch(const SettingField& field) { return field.type == SettingType::Switch; }
bool is_text(const SettingField& field) { return !is_number(field) && !is_switch(field); }

bool in_range(const SettingRange& range, double value) {
  return (value >= range.least && value <= range.most) || (range.besides && value == *range.besides);
}

std::string words_of(const SettingField& field) {
  if (field.type == SettingType::Gains)
    return fmt::format("{}, or gains of R, G and B from 1/64 to 64, such as 2,1,1.5",
                       fmt::join(field.choices, ", "));
  if (field.list) return fmt::format("any of {}", fmt::join(field.choices, ","));
  const auto last = field.choices.end() - 1;
  return fmt::format("{} or {}", fmt::join(field.choices.begin(), last, ", "), *last);
}

std::string shown(const SettingValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text ? fmt::format("'{}'", *text) : to_text(value);
}

// The given value, converted to the field's own type.
std::optional<SettingValue> converted(const SettingField& field, const SettingValue& value) {
  if (field.type == SettingType::Knob) return to_text(value);
  const bool numbers_are_texts = field.list || !field.choices.empty() || field.type == SettingType::Delay;
  if (is_text(field)) {
    if (std::holds_alternative<std::string>(value)) return value;
    if (numbers_are_texts && !std::holds_alternative<bool>(value)) return to_text(value);
    return std::nullopt;
  }
  if (is_switch(field)) return std::holds_alternative<bool>(value) ? std::optional(value) : std::nullopt;
  const auto* whole = std::get_if<int>(&value);
  const auto* real = std::get_if<double>(&value);
  if (field.type == SettingType::Real && whole) return static_cast<double>(*whole);
  if (field.type == SettingType::Whole && real && std::abs(*real) <= kUnlimited && *real == std::trunc(*real))
    return static_cast<int>(*real);
  if (field.type == SettingType::Real ? real != nullptr : whole != nullptr) return value;
  return std::nullopt;
}

bool is_meant_by(const std::string& choice, const std::string& word) {
  constexpr std::string_view kAnyName = "NAME";
  if (!choice.ends_with(":NAME")) return word == choice;
  const std::string_view beginning(choice.data(), choice.size() - kAnyName.size());
  return word.size() > beginning.size() && word.starts_with(beginning);
}

// The first word that is not one of the field's.
std::optional<std::string> stranger(const SettingField& field, const std::string& text) {
  if (field.choices.empty() || field.type == SettingType::Gains) return std::nullopt;
  for (const std::string& word : field.list ? parts_of(text) : std::vector{text})
    if (std::ranges::none_of(field.choices, [&](const auto& choice) { return is_meant_by(choice, word); }))
      return word;
  return std::nullopt;
}

bool allowed(const SettingField& field, const SettingValue& value) {
  if (field.type == SettingType::Knob) {
    Knobs knobs;
    const auto& text = std::get<std::string>(value);
    return text.empty() || set_knob(knobs, field.knob->name, text).ok();
  }
  if (field.type == SettingType::TimeOrOff) {
    const auto& text = std::get<std::string>(value);
    return text.empty() || text == kOff || parse_duration(text).ok();
  }
  if (field.type == SettingType::Time) return parse_duration(std::get<std::string>(value)).ok();
  if (field.type == SettingType::Delay) return parse_signed_duration(std::get<std::string>(value)).ok();
  if (field.type == SettingType::Gains) return parse_white_balance(std::get<std::string>(value)).has_value();
  if (const auto* text = std::get_if<std::string>(&value)) return !stranger(field, *text);
  if (const auto* whole = std::get_if<int>(&value)) return in_range(field.range, *whole);
  if (const auto* real = std::get_if<double>(&value)) return in_range(field.range, *real);
  return true;
}

}  // namespace

std::vector<std::string> parts_of(std::string_view text) {
  std::vector<std::string> parts;
  for (const std::string_view part : split_list(text, ',')) parts.emplace_back(trimmed(part, " "));
  return parts;
}

std::string describe(const SettingField& field) {
  std::vector<std::string> notes;
  if (field.type == SettingType::Knob) notes.push_back(accepted_values(*field.knob));
  if (field.type == SettingType::TimeOrOff) notes.push_back(accepted(field));
  if (!field.choices.empty()) notes.push_back(words_of(field));
  if (is_number(field) && field.range.most < kUnlimited)
    notes.push_back(fmt::format("{}..{}", field.range.least, field.range.most));
  if (*field.unset != '\0')
    notes.push_back(
        fmt::format("{}: {}", is_number(field) ? to_text(*field.range.besides) : "\"\"", field.unset));
  return notes.empty() ? field.about : fmt::format("{} ({})", field.about, fmt::join(notes, "; "));
}

std::string accepted(const SettingField& field) {
  if (field.type == SettingType::Knob) return accepted_values(*field.knob);
  if (!field.choices.empty()) return words_of(field);
  if (field.type == SettingType::TimeOrOff) return fmt::format("a time such as 33ms, or {}", kOff);
  if (field.type == SettingType::Time) return "a time such as 250us or 1ms, more than 0";
  if (field.type == SettingType::Delay) return "a time such as 250us, -2ms or 0";
  if (is_switch(field)) return "true or false";
  if (!is_number(field)) return field.list ? "a text or a list" : "a text";
  const std::string_view unit = field.range.unit;
  const std::string range =
      fmt::format("{}, {}..{}{}{}", field.type == SettingType::Whole ? "a whole number" : "a number",
                  field.range.least, field.range.most, unit.empty() ? "" : " ", unit);
  return field.range.besides ? fmt::format("{} or {}", range, *field.range.besides) : range;
}

std::string to_text(const SettingValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

Error not_accepted(const SettingField& field, std::string_view name, std::string_view shown) {
  return {ErrorCode::Invalid, fmt::format("{} takes {}, not {}", name, accepted(field), shown)};
}

Result<void> set(const SettingField& field, const SettingValue& given, std::string_view name,
                 Settings& settings) {
  const auto value = converted(field, given);
  if (!value || !allowed(field, *value)) {
    const std::string text = to_text(given);
    const std::string wrong = is_text(field) ? stranger(field, text).value_or(text) : text;
    return not_accepted(field, name,
                        (wrong == text ? shown(given) : fmt::format("'{}'", wrong)) +
                            did_you_mean(wrong, field.knob != nullptr ? field.knob->choices : field.choices));
  }
  if (field.type == SettingType::Times) TRY(parse_exposures(std::get<std::string>(*value), ""));
  field.write(settings, *value);
  return {};
}

Result<void> set_from_text(const SettingField& field, const std::string& text, std::string_view name,
                           Settings& settings) {
  std::optional<SettingValue> value;
  if (is_text(field)) value = text;
  if (is_switch(field) && (text == "true" || text == "false")) value = text == "true";
  if (field.type == SettingType::Whole) value = parse_number<int>(text);
  if (field.type == SettingType::Real) value = parse_number<double>(text);
  return set(field, value.value_or(text), name, settings);
}

}  // namespace hdrcam
