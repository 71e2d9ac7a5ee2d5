#include "firmware_host/settings/settings_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <utility>

#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/settings_toml.h"
#include "firmware_host/settings/suggestion.h"
#include "firmware_host/terminal.h"
#include "hal/core/check.h"

namespace hdrcam {
namespace {

const char* type_name(SettingType type) {
  switch (type) {  // as CLI11 calls them
    case SettingType::Whole:
      return "INT";
    case SettingType::Real:
      return "FLOAT";
    default:
      return "TEXT";
  }
}

// Of settings, or "knobs": a misspelt one would be asked for in vain.
void check_keys(const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    HDRCAM_CHECK(key == "knobs" ||
                 std::ranges::find(setting_fields(), key, &SettingField::key) != setting_fields().end());
}

CLI::Option* add_flag(CLI::App& verb, const SettingField& field, const char* flag) {
  const std::string help = describe(field);
  if (field.type == SettingType::Switch) return verb.add_flag(flag, help);
  CLI::Option* option = verb.add_option(flag, help)
                            ->type_name(type_name(field.type))
                            ->default_str(to_text(field.read(Settings{})));
  return field.names_file ? option->check(names_file) : option;
}

Result<void> set_knob_from(const std::string& assignment, const std::vector<const SettingField*>& knobs,
                           Settings& settings) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  if (equals == std::string::npos)
    return Error{ErrorCode::Invalid,
                 fmt::format("--set {} has no value; write NAME=VALUE, such as --set steps=100", assignment)};
  std::vector<std::string> names;
  for (const SettingField* field : knobs) {
    if (field->knob->name == name)
      return set_from_text(*field, assignment.substr(equals + 1), name, settings);
    names.push_back(field->knob->name);
  }
  return Error{ErrorCode::Invalid, fmt::format("there is no knob '{}'{}; --print-config lists them", name,
                                               did_you_mean(name, names))};
}

// What of the command line set each knob, by the knob's name: "--set look_ahead=2", "--lookahead 0".
class KnobsGiven {
 public:
  // Error: an earlier one set the same knob.
  Result<void> add(const std::string& knob, const std::string& words) {
    const auto [first, is_first] = words_.try_emplace(knob, words);
    if (is_first) return {};
    return Error{ErrorCode::Invalid,
                 fmt::format("{} and {} set the same knob; leave out one of them", first->second, words)};
  }

 private:
  std::map<std::string, std::string> words_;
};

}  // namespace

struct SettingsFlags::Given {
  struct Flag {
    const SettingField* field;
    CLI::Option* option;
  };
  std::vector<Flag> flags;
  std::vector<const SettingField*> knobs;
  std::vector<std::string> assignments;  // of --set, in their order
  std::string config;
  bool print_config = false;

  void add(CLI::App& verb, const SettingField& field, const char* flag) {
    if (field.type == SettingType::Knob) return knobs.push_back(&field);
    CLI::Option* option = add_flag(verb, field, flag);
    option->group(title(field.group));
    flags.push_back({&field, option});
  }
  void add_config(CLI::App& verb) {
    if (!knobs.empty())
      verb.add_option("--set", assignments,
                      "set a knob of the method, NAME=VALUE; --print-config lists them; may be repeated")
          ->type_name("NAME=VALUE")
          ->take_all()
          ->expected(1)
          ->allow_extra_args(false)
          ->group(title(SettingGroup::Fit));
    verb.add_option("--config", config, "settings in TOML; flags override them")
        ->check(names_file)
        ->group("Configuration");
    if (flags.empty()) return;
    // What a run needs is not needed to print its settings.
    const auto print_instead = [this, &verb](std::int64_t count) {
      print_config = count > 0;  // not of --print-config=false
      if (!print_config) return;
      for (CLI::Option* option : verb.get_options()) option->required(false);
    };
    verb.add_flag_function("--print-config", print_instead, "print the settings as such a file and exit")
        ->group("Configuration");
  }
  bool takes(const SettingField& field) const {
    return std::ranges::find(flags, &field, &Flag::field) != flags.end() ||
           std::ranges::find(knobs, &field) != knobs.end();
  }
};

SettingsFlags::SettingsFlags(CommandLine verb, const std::vector<SettingGroup>& groups,
                             const std::vector<std::string>& left_out)
    : given_(std::make_unique<Given>()) {
  check_keys(left_out);
  for (const SettingField& field : setting_fields())
    if (std::ranges::find(groups, field.group) != groups.end() &&
        std::ranges::find(left_out, field.key) == left_out.end())
      given_->add(verb.parser(), field, flag_of(field, groups));
  given_->add_config(verb.parser());
}

SettingsFlags::SettingsFlags(CommandLine verb, const std::vector<std::string>& keys)
    : given_(std::make_unique<Given>()) {
  check_keys(keys);
  for (const SettingField& field : setting_fields())
    if (std::ranges::find(keys, field.key) != keys.end()) given_->add(verb.parser(), field, field.flag);
  given_->add_config(verb.parser());
}

SettingsFlags::~SettingsFlags() = default;

Result<Settings> SettingsFlags::read(Storage& storage) const {
  Settings settings;
  if (!given_->config.empty()) {
    const std::string text = TRY(read_whole(storage, given_->config));
    if (text.find('\0') != std::string::npos)
      return Error{
          ErrorCode::Invalid,
          fmt::format("'{}' is not a file of settings, which is text in TOML; --print-config prints one",
                      given_->config)};
    TRY(read_toml(text, given_->config, settings));
  }
  KnobsGiven knobs;
  for (const auto& [field, option] : given_->flags) {
    if (option->count() == 0) continue;
    const auto value = option->as<std::string>();
    TRY(set_from_text(*field, value, option->get_name(), settings));
    if (field->knob != nullptr)
      TRY(knobs.add(field->knob->name, fmt::format("{} {}", option->get_name(), value)));
  }
  for (const std::string& assignment : given_->assignments) {
    TRY(set_knob_from(assignment, given_->knobs, settings));
    TRY(knobs.add(assignment.substr(0, assignment.find('=')), "--set " + assignment));
  }
  if (settings.machine.log_format == LogFormat::Json) set_log_format(LogFormat::Json);
  return settings;
}

Result<std::optional<Settings>> SettingsFlags::read_or_print(Storage& storage) const {
  Settings settings = TRY(read(storage));
  if (!given_->print_config) return std::optional(std::move(settings));
  write_result(printed(settings));
  return std::optional<Settings>();
}

std::string SettingsFlags::printed(const Settings& settings) const {
  std::vector<const SettingField*> all;
  for (const SettingField& field : setting_fields())
    if (given_->takes(field)) all.push_back(&field);
  return to_toml(settings, all);
}

std::vector<std::string> SettingsFlags::given(const std::vector<std::string>& keys) const {
  check_keys(keys);
  std::vector<std::string> flags;
  for (const auto& [field, option] : given_->flags) {
    if (option->count() == 0 || std::ranges::find(keys, field->key) == keys.end()) continue;
    const bool off = field->type == SettingType::Switch && option->as<std::string>() == "false";
    if (!off) flags.push_back(option->get_name());
  }
  if (!given_->assignments.empty() && std::ranges::find(keys, "knobs") != keys.end())
    flags.emplace_back("--set");
  return flags;
}

std::string SettingsFlags::as_flags(const Settings& settings) const {
  std::string text;
  std::map<std::string, std::string> to_set = settings.fit.knobs;
  for (const auto& [field, option] : given_->flags) {
    const SettingValue value = field->read(settings);
    if (field->secret || value == field->read(Settings{})) continue;
    text += fmt::format(" {}={}", option->get_name(), shell_word(to_text(value)));
    if (field->knob != nullptr) to_set.erase(field->knob->name);
  }
  for (const auto& [name, value] : to_set)
    if (!given_->knobs.empty()) text += " --set " + shell_word(fmt::format("{}={}", name, value));
  return text;
}

}  // namespace hdrcam
