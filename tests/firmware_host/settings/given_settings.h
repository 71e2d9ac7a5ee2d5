// Settings as a command line or a file gives them, and what is said of those that are refused.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/settings_flags.h"
#include "firmware_host/settings/settings_toml.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

namespace hdrcam::test {

inline const std::vector<SettingGroup> kAllGroups{
    SettingGroup::Camera, SettingGroup::Schedule, SettingGroup::Sync,   SettingGroup::Fit,
    SettingGroup::Knobs,  SettingGroup::Output,   SettingGroup::Record, SettingGroup::Machine};

inline std::string file_with(const std::string& text) {
  static const std::string folder = sample::scratch_folder("settings");
  const std::string path = folder + "/live.toml";
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(text))).ok());
  return path;
}

// What a verb of these groups makes of a command line.
inline Result<Settings> from_flags(const std::vector<std::string>& words,
                                   const std::vector<SettingGroup>& groups = kAllGroups) {
  CLI::App verb("", "live");
  const SettingsFlags flags(verb, groups);
  verb.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  return flags.read(posix_storage());
}

inline Result<Settings> from_toml(const std::string& text) {
  Settings settings;
  const auto read = read_toml(text, "live.toml", settings);
  return read ? Result<Settings>(settings) : read.error();
}

inline std::string sentence(const Result<Settings>& refused) {
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::Invalid);
  return refused.error().message;
}

// A value that the field takes and that is not its default.
inline std::string other_value(const SettingField& field) {
  switch (field.type) {
    case SettingType::Choice:
    case SettingType::Words:
      return field.choices.back();
    case SettingType::Switch:
      return "true";
    case SettingType::Whole:
      return to_text(field.range.most);
    case SettingType::Real:
      return to_text(field.range.least + (field.range.most - field.range.least) / 3);
    case SettingType::Time:
    case SettingType::TimeOrOff:
      return "33ms";
    case SettingType::Delay:
      return "-2ms";
    case SettingType::Times:
      return "250us, 1/60";
    case SettingType::Gains:
      return "2,1,1.5";
    case SettingType::Knob:
      return field.knob->kind == KnobKind::Choice ? field.knob->choices.back() : to_text(field.knob->least);
    case SettingType::Text:
      break;
  }
  return "a \"quoted\" \\ word, wörtlich\tand\n=[#]";
}

inline Settings all_changed() {
  Settings settings;
  for (const SettingField& field : setting_fields())
    REQUIRE(set_from_text(field, other_value(field), field.key, settings).ok());
  return settings;
}

}  // namespace hdrcam::test
