#include "firmware_host/settings/settings_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/settings_toml.h"

namespace hdrcam {
namespace {

constexpr const char* kPlainInAShell =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789%+,-./:=@_";

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

CLI::Option* add_flag(CLI::App& verb, const SettingField& field, const char* flag) {
  const std::string help = describe(field);
  if (field.type == SettingType::Switch) return verb.add_flag(flag, help);
  return verb.add_option(flag, help)
      ->type_name(type_name(field.type))
      ->default_str(to_text(field.read(Settings{})));
}

}  // namespace

struct SettingsFlags::Given {
  std::vector<const SettingField*> fields;
  std::vector<CLI::Option*> options;  // one for each
  std::string config;
  bool print_config = false;

  void add(CLI::App& verb, const SettingField& field, const char* flag) {
    CLI::Option* option = add_flag(verb, field, flag);
    option->group(title(field.group));
    fields.push_back(&field);
    options.push_back(option);
  }
  void add_config(CLI::App& verb) {
    verb.add_option("--config", config, "settings in TOML; flags come on top of them")
        ->group("Configuration");
    if (fields.empty()) return;
    verb.add_flag("--print-config", print_config, "print the settings as such a file, and end")
        ->group("Configuration");
  }
};

SettingsFlags::SettingsFlags(CLI::App& verb, const std::vector<SettingGroup>& groups)
    : given_(std::make_unique<Given>()) {
  for (const SettingField& field : setting_fields())
    if (std::ranges::find(groups, field.group) != groups.end())
      given_->add(verb, field, flag_of(field, groups));
  given_->add_config(verb);
}

SettingsFlags::SettingsFlags(CLI::App& verb, const std::vector<std::string>& keys)
    : given_(std::make_unique<Given>()) {
  for (const SettingField& field : setting_fields())
    if (std::ranges::find(keys, field.key) != keys.end()) given_->add(verb, field, field.flag);
  given_->add_config(verb);
}

SettingsFlags::~SettingsFlags() = default;

Result<Settings> SettingsFlags::read(Storage& storage) const {
  Settings settings;
  if (!given_->config.empty()) {
    const std::string text = TRY(read_whole(storage, given_->config));
    TRY(read_toml(text, given_->config, settings));
  }
  for (std::size_t i = 0; i < given_->fields.size(); ++i) {
    const CLI::Option& option = *given_->options[i];
    if (option.count() > 0)
      TRY(set_from_text(*given_->fields[i], option.as<std::string>(), option.get_name(), settings));
  }
  return settings;
}

bool SettingsFlags::print_config() const { return given_->print_config; }

std::string SettingsFlags::printed(const Settings& settings) const {
  return to_toml(settings, given_->fields);
}

std::string SettingsFlags::as_flags(const Settings& settings) const {
  std::string text;
  for (std::size_t i = 0; i < given_->fields.size(); ++i) {
    const SettingValue value = given_->fields[i]->read(settings);
    if (value == given_->fields[i]->read(Settings{})) continue;
    const std::string word = to_text(value);
    const bool plain = word.find_first_not_of(kPlainInAShell) == std::string::npos && !word.empty();
    text += fmt::format(" {}={}", given_->options[i]->get_name(), plain ? word : '\'' + word + '\'');
  }
  return text;
}

}  // namespace hdrcam
