// Makes a field that reads and writes a member of Settings, by what the member holds. kGroup:
// &Settings::camera; kMember: &Settings::Camera::width; key, flag, about and unset as in SettingField.
// Reentrant.
#pragma once

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "firmware_host/settings/setting_field.h"

namespace hdrcam::member_fields {

template <class T>
inline constexpr SettingType kTypeOf = std::is_same_v<T, bool>     ? SettingType::Switch
                                       : std::is_same_v<T, int>    ? SettingType::Whole
                                       : std::is_same_v<T, double> ? SettingType::Real
                                                                   : SettingType::Text;

template <auto kGroup, auto kMember>
using MemberType = std::remove_cvref_t<decltype(std::declval<Settings>().*kGroup.*kMember)>;

template <auto kGroup, auto kMember>
SettingField any(const char* key, const char* flag, const char* about, const char* unset = "") {
  using T = MemberType<kGroup, kMember>;
  SettingField field;
  field.type = kTypeOf<T>;
  field.key = key, field.flag = flag;
  field.read = [](const Settings& s) -> SettingValue { return s.*kGroup.*kMember; };
  field.write = [](Settings& s, const SettingValue& value) { s.*kGroup.*kMember = std::get<T>(value); };
  field.about = about, field.unset = unset;
  return field;
}

template <auto kGroup, auto kMember>
SettingField file(const char* key, const char* flag, const char* about, const char* unset = "") {
  SettingField field = any<kGroup, kMember>(key, flag, about, unset);
  field.names_file = true;
  return field;
}

template <auto kGroup, auto kMember>
SettingField time(const char* key, const char* flag, const char* about) {
  SettingField field = any<kGroup, kMember>(key, flag, about);
  field.type = SettingType::Time;
  return field;
}

template <auto kGroup, auto kMember>
SettingField delay(const char* key, const char* flag, const char* about) {
  SettingField field = any<kGroup, kMember>(key, flag, about);
  field.type = SettingType::Delay;
  return field;
}

template <auto kGroup, auto kMember>
SettingField list(const char* key, const char* flag, const char* about, const char* unset = "") {
  SettingField field = any<kGroup, kMember>(key, flag, about, unset);
  field.list = true;
  return field;
}

template <auto kGroup, auto kMember>
SettingField number(const char* key, const char* flag, const char* about, SettingRange range,
                    const char* unset = "") {
  SettingField field = any<kGroup, kMember>(key, flag, about, unset);
  field.range = range;
  return field;
}

template <auto kGroup, auto kMember>
SettingField times(const char* key, const char* flag, const char* about) {
  SettingField field = list<kGroup, kMember>(key, flag, about);
  field.type = SettingType::Times;
  return field;
}

// A word of a setting and what it stands for.
template <class T>
using Meanings = std::vector<std::pair<const char*, T>>;

template <class T>
std::vector<std::string> words_of(const Meanings<T>& meanings) {
  std::vector<std::string> words;
  for (const auto& [word, meaning] : meanings) words.emplace_back(word);
  return words;
}

template <auto kGroup, auto kMember>
SettingField choice(const char* key, const char* flag, const char* about,
                    const Meanings<MemberType<kGroup, kMember>>& meanings) {
  SettingField field;
  field.type = SettingType::Choice;
  field.key = key, field.flag = flag, field.about = about;
  field.choices = words_of(meanings);
  field.read = [meanings](const Settings& s) -> SettingValue {
    for (const auto& [word, value] : meanings)
      if (s.*kGroup.*kMember == value) return std::string(word);
    return std::string();
  };
  field.write = [meanings](Settings& s, const SettingValue& given) {
    for (const auto& [word, value] : meanings)
      if (std::get<std::string>(given) == word) s.*kGroup.*kMember = value;
  };
  return field;
}

// Each word switches a flag of the member.
template <auto kGroup, auto kMember>
SettingField words(const char* key, const char* flag, const char* about, const char* unset,
                   const Meanings<bool MemberType<kGroup, kMember>::*>& meanings) {
  SettingField field;
  field.type = SettingType::Words;
  field.key = key, field.flag = flag, field.about = about, field.unset = unset;
  field.choices = words_of(meanings);
  field.list = true;
  field.read = [meanings](const Settings& s) -> SettingValue {
    std::string text;
    for (const auto& [word, on] : meanings)
      if (s.*kGroup.*kMember.*on) text += (text.empty() ? "" : ",") + std::string(word);
    return text;
  };
  field.write = [meanings](Settings& s, const SettingValue& value) {
    const std::vector<std::string> given = parts_of(std::get<std::string>(value));
    for (const auto& [word, on] : meanings)
      s.*kGroup.*kMember.*on = std::ranges::find(given, word) != given.end();
  };
  return field;
}

}  // namespace hdrcam::member_fields
