#include "firmware_host/settings/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/settings_toml.h"

namespace hdrcam {
namespace {

const char* type_name(const SettingField& field) {
  static constexpr const char* kNames[] = {"TEXT", "INT", "FLOAT"};  // as CLI11 calls them
  return kNames[field.place.index()];
}

CLI::Option* add_flag(CLI::App& verb, const SettingField& field, const char* flag) {
  const std::string help = describe(field);
  if (std::holds_alternative<SettingPlace<bool>>(field.place)) return verb.add_flag(flag, help);
  return verb.add_option(flag, help)
      ->type_name(type_name(field))
      ->default_str(to_text(value_of(field, Settings{})));
}

}  // namespace

struct SettingsFlags::Given {
  std::vector<std::pair<const SettingField*, CLI::Option*>> flags;
  std::string config;
  bool print_config = false;
};

SettingsFlags::SettingsFlags(CLI::App& verb, std::vector<SettingGroup> groups)
    : given_(std::make_unique<Given>()) {
  for (const SettingField& field : setting_fields()) {
    if (std::ranges::find(groups, field.group) == groups.end()) continue;
    CLI::Option* option = add_flag(verb, field, flag_of(field, groups));
    option->group(title(field.group));
    given_->flags.emplace_back(&field, option);
  }
  verb.add_option("--config", given_->config, "settings in TOML; flags come on top of them")
      ->group("Configuration");
  verb.add_flag("--print-config", given_->print_config, "print the settings as such a file, and end")
      ->group("Configuration");
}

SettingsFlags::~SettingsFlags() = default;

Result<Settings> SettingsFlags::read(Storage& storage) const {
  Settings settings;
  if (!given_->config.empty()) {
    const std::string text = TRY(read_whole(storage, given_->config));
    TRY(read_toml(text, given_->config, settings));
  }
  for (const auto& [field, option] : given_->flags)
    if (option->count() > 0)
      TRY(set_from_text(*field, option->as<std::string>(), option->get_name(), settings));
  return settings;
}

bool SettingsFlags::print_config() const { return given_->print_config; }

}  // namespace hdrcam
