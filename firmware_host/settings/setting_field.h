// One setting: its key in a TOML file, its flag, its meaning, its valid values and its member in Settings;
// and the checking and setting of a given value. Reentrant.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "firmware_host/settings/settings.h"
#include "hal/core/result.h"

namespace hdrcam {

// Choice: one of the field's words, an enum in Settings. Words: any of them, joined by commas. Knob: a value
// for a knob of the method (online/knobs.h); "" keeps the preset's value. Time: a time of more than 0.
// TimeOrOff: such a time, or "off". Delay: a time with a sign, or 0. Times: exposure times, joined by commas.
// Gains: one of the words, or factors of R, G and B.
enum class SettingType {
  Text,
  Whole,
  Real,
  Switch,
  Choice,
  Words,
  Knob,
  Time,
  TimeOrOff,
  Delay,
  Times,
  Gains
};

// A value as given or printed; choices and words are texts.
using SettingValue = std::variant<std::string, int, double, bool>;

// The most of a whole number that has no limit of its own; the help then says none.
inline constexpr int kUnlimited = std::numeric_limits<int>::max();

// The range of a number: least..most, or the one value besides that means "not set".
struct SettingRange {
  double least = 0, most = 0;
  std::optional<double> besides;
  const char* unit = "";  // where people tend to write another: "MiB"
};

struct SettingField {
  SettingGroup group = SettingGroup::Camera;
  SettingType type = SettingType::Text;
  std::string key;        // "camera.format": table and name
  const char* flag = "";  // "--format", or "-o,--output"; "" for a knob, which --set sets
  std::function<SettingValue(const Settings&)> read;
  std::function<void(Settings&, const SettingValue&)> write;  // with a valid value
  std::string about;                                          // a clause, with the unit
  const char* unset = "";            // meaning of "", or of the number besides the range
  SettingRange range;                // of a number
  std::vector<std::string> choices;  // of Choice and Words; one that ends in ":NAME" accepts any name there
  bool list = false;                 // parts joined by commas; TOML also accepts an array
  const Knob* knob = nullptr;        // of a Knob, and of a number whose flag sets one
  bool secret = false;               // left out of the command line that a run records
  bool names_file = false;           // its flag takes no empty name
};

// The clause with the range or the choices, and the meaning of an unset field.
std::string describe(const SettingField& field);

// The valid values for "takes ...": "a whole number, 4..32".
std::string accepted(const SettingField& field);

std::string to_text(const SettingValue& value);  // as a flag takes it

// The parts of "a,b, c", without the blanks around them; none of "".
std::vector<std::string> parts_of(std::string_view text);

// Error: Invalid, "NAME takes ACCEPTED, not VALUE"; `name` is the field's name in the message. Of Times what
// is wrong with one of them, as parse_exposures says it. The first form reads the value from a text, as a
// flag gives it; the second one also accepts a whole number for a number and for a choice.
Result<void> set_from_text(const SettingField& field, const std::string& text, std::string_view name,
                           Settings& settings);
Result<void> set(const SettingField& field, const SettingValue& value, std::string_view name,
                 Settings& settings);
Error not_accepted(const SettingField& field, std::string_view name, std::string_view shown);

}  // namespace hdrcam
