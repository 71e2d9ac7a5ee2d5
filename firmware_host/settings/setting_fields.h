// The list of all settings: for each its key in a TOML file, its flag, what it is about, what it takes and
// where it lives in Settings. The flags, the file, the help, the printed configuration and
// docs/configuration.md all come from this list, so they cannot disagree. Reentrant.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "firmware_host/settings/settings.h"

namespace hdrcam {

// A member of Settings, to read and to write.
template <class T>
struct SettingPlace {
  const T& (*of)(const Settings&);
  T& (*in)(Settings&);
};

// What a number may be: least..most, or the one value besides that means "not set".
struct SettingRange {
  double least = 0, most = 0;
  std::optional<double> besides;
};

struct SettingField {
  SettingGroup group = SettingGroup::Camera;
  const char* key = "";   // "camera.format": table and name
  const char* flag = "";  // "--format", or "-o,--output"
  std::variant<SettingPlace<std::string>, SettingPlace<int>, SettingPlace<double>, SettingPlace<bool>> place;
  const char* about = "";            // a clause, with the unit
  const char* unset = "";            // what "", or the number besides the range, stands for
  SettingRange range;                // of a number
  std::vector<std::string> choices;  // of a text; none: any text
  bool list = false;                 // a text of parts joined by commas; in TOML an array will do, too
};

using SettingValue = std::variant<std::string, int, double, bool>;

// In the order in which they are printed: group by group.
std::span<const SettingField> setting_fields();

const char* title(SettingGroup group);  // "Sync line"

// The flag by which a verb of these groups takes the field: --record is -o where no HDR frames go out.
const char* flag_of(const SettingField& field, std::span<const SettingGroup> groups);

// The clause with the range or the choices, and what the field means when it is not set.
std::string describe(const SettingField& field);

// "takes ..." for a sentence: "a whole number, 4..32".
std::string accepted(const SettingField& field);

SettingValue value_of(const SettingField& field, const Settings& settings);
std::string to_text(const SettingValue& value);  // as a flag takes it

// Error: Invalid, "NAME takes ACCEPTED, not VALUE"; `name` is what the user called the field. The first form
// reads the value from a text, as a flag gives it; the second one takes a whole number for a number and
// for a choice, too.
Result<void> set_from_text(const SettingField& field, const std::string& text, std::string_view name,
                           Settings& settings);
Result<void> set(const SettingField& field, const SettingValue& value, std::string_view name,
                 Settings& settings);
Error not_accepted(const SettingField& field, std::string_view name, std::string_view shown);

}  // namespace hdrcam
