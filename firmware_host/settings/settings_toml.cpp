#include "firmware_host/settings/settings_toml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <optional>
#include <vector>

#include "firmware_host/printable.h"
#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/suggestion.h"

// toml++ 3.3 asserts conditions that a damaged file can violate and, with NDEBUG, lets the compiler assume
// them. Without either it reaches the branches that report the mistake.
#undef NDEBUG
#define TOML_ASSERT(expr) static_cast<void>(0)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

namespace hdrcam {
namespace {

// One key of the file with its value.
struct Entry {
  std::string key;  // "camera.format", or "camra" where there is no such table
  const toml::node* node = nullptr;
  std::uint32_t line = 0;
};

std::string_view table_of(std::string_view key) { return key.substr(0, key.find('.')); }
std::string_view name_of(std::string_view key) { return key.substr(key.find('.') + 1); }

std::vector<std::string> tables() {
  std::vector<std::string> names;
  for (const SettingField& field : setting_fields())
    if (names.empty() || names.back() != table_of(field.key)) names.emplace_back(table_of(field.key));
  return names;
}

// The parser recurses for every part of a dotted key and limits only the brackets, so a limit of dots bounds
// its stack.
Result<void> check_size(std::string_view text, const std::string& name) {
  const auto dots = static_cast<std::size_t>(std::ranges::count(text, '.'));
  if (text.size() <= kMostTomlBytes && dots <= kMostTomlDots) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("'{}' has {} bytes and {} dots; a file of settings has at most {} and {}", name,
                           text.size(), dots, kMostTomlBytes, kMostTomlDots)};
}

Error at_line(const std::string& name, std::uint32_t line, const Error& error) {
  return {error.code, fmt::format("{}:{}: {}", name, line, printable(error.message))};
}

// Refuses letters such as é outside of quotes and comments, on which toml++ 3.3 has undefined behaviour, and
// multi-line texts, which no setting uses. Agrees with the parser up to the first mistake of a file.
Result<void> check_letters(std::string_view text, const std::string& name) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::uint32_t line = 1;
  char inside = '\n';  // of a quote or comment, by the character that opened it
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      ++line, inside = '\n';
    } else if (inside == '"' && c == '\\' && !text.substr(i + 1).starts_with('\n')) {
      ++i;
    } else if (inside != '\n') {
      if (c == inside && c != '#') inside = '\n';
    } else if (c == '"' || c == '\'' || c == '#') {
      inside = c;
      if (c != '#' && text.substr(i).starts_with(std::string(3, c)))
        return at_line(name, line, {ErrorCode::Invalid, "no setting is a multi-line text"});
    } else if (static_cast<unsigned char>(c) >= 0x80) {
      return at_line(name, line, {ErrorCode::Invalid, "a letter outside ASCII needs quotes; write \"é\""});
    }
  }
  return {};
}

bool is_setting(std::string_view key) {
  return std::ranges::find(setting_fields(), key, &SettingField::key) != setting_fields().end();
}

// Keys below `place`. A table below a table is part of the names of knobs: state.blur_weight.
void add_entries(const toml::table& table, const std::string& place, std::vector<Entry>& entries) {
  const auto fields = setting_fields();
  for (const auto& [name, value] : table) {
    const std::string key = fmt::format("{}.{}", place, name.str());
    const bool begins_a_name = std::ranges::any_of(
        fields, [&](const SettingField& field) { return field.key.starts_with(key + '.'); });
    if (value.is_table() && begins_a_name && !is_setting(key))
      add_entries(*value.as_table(), key, entries);
    else
      entries.push_back({key, &value, name.source().begin.line});
  }
}

std::vector<Entry> entries_of(const toml::table& file) {
  const auto known = tables();
  std::vector<Entry> entries;
  for (const auto& [key, node] : file) {
    const toml::table* table = node.as_table();
    if (!table || std::ranges::find(known, key.str()) == known.end()) {
      entries.push_back({std::string(key.str()), &node, key.source().begin.line});
      continue;
    }
    add_entries(*table, std::string(key.str()), entries);
  }
  std::ranges::stable_sort(entries, {}, &Entry::line);
  return entries;
}

// Returns text like " (did you mean 'camera.width'?)": by the whole key, otherwise by the name in any table;
// otherwise where to look.
std::string nearest_setting(const std::string& key) {
  std::vector<std::string> keys, names;
  for (const SettingField& field : setting_fields()) {
    keys.emplace_back(field.key);
    names.emplace_back(name_of(field.key));
  }
  if (nearest_word(key, keys)) return did_you_mean(key, keys);
  const auto name = nearest_word(name_of(key), names);
  if (!name) return "; --print-config lists all settings";
  return did_you_mean(keys[static_cast<std::size_t>(std::ranges::find(names, *name) - names.begin())], keys);
}

Error no_such(const Entry& entry) {
  const auto known = tables();
  if (std::ranges::find(known, entry.key) != known.end())
    return {ErrorCode::Invalid, fmt::format("'{0}' is a table; write [{0}] above its settings", entry.key)};
  if (entry.node->is_table() && entry.key.find('.') == std::string::npos)
    return {ErrorCode::Invalid, fmt::format("there is no table [{}]{}; there are {}", entry.key,
                                            did_you_mean(entry.key, known), fmt::join(known, ", "))};
  return {ErrorCode::Invalid,
          fmt::format("there is no setting '{}'{}", entry.key, nearest_setting(entry.key))};
}

std::optional<SettingValue> scalar(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* real = node.as_floating_point()) return real->get();
  if (const auto* truth = node.as_boolean()) return truth->get();
  const auto* whole = node.as_integer();
  if (!whole) return std::nullopt;
  if (std::in_range<int>(whole->get())) return static_cast<int>(whole->get());
  return static_cast<double>(whole->get());  // outside every range; shown as written
}

// The parts of a list, joined as a flag takes them.
std::optional<SettingValue> joined(const toml::array& array) {
  std::vector<std::string> parts;
  for (const toml::node& element : array) {
    const auto part = scalar(element);
    if (!part || std::holds_alternative<bool>(*part)) return std::nullopt;
    parts.push_back(to_text(*part));
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

const char* word_for(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (node.is_array()) return "this list";
  return "a date or time";
}

Result<void> take(const Entry& entry, Settings& settings) {
  const auto fields = setting_fields();
  const auto field = std::ranges::find(fields, entry.key, &SettingField::key);
  if (field == fields.end()) return no_such(entry);
  auto value = scalar(*entry.node);
  if (field->list && entry.node->is_array()) value = joined(*entry.node->as_array());
  if (!value) return not_accepted(*field, entry.key, word_for(*entry.node));
  return set(*field, *value, entry.key, settings);
}

std::string quoted(const std::string& text) {
  std::string masked;
  for (const char c : text) {
    if (c == '"' || c == '\\') masked += '\\';
    masked += c;
  }
  return '"' + printable(masked) + '"';
}

// Returns a line like "width = 640". A knob with the preset's value is in a comment, so that the file follows
// the preset.
std::string line_of(const SettingField& field, const Settings& settings) {
  const SettingValue value = field.read(settings);
  const auto* words = std::get_if<std::string>(&value);
  std::string text = words ? quoted(*words) : to_text(value);
  const bool unset = field.type == SettingType::Knob && words->empty();
  if (unset) text = quoted(knob_value(knobs_of(settings.fit.preset), field.knob->name).value());
  return fmt::format("{}{} = {}", unset ? "#" : "", name_of(field.key), text);
}

}  // namespace

Result<void> read_toml(std::string_view text, const std::string& name, Settings& settings) {
  TRY(check_size(text, name));
  TRY(check_letters(text, name));
  const toml::parse_result parsed = toml::parse(text, name);
  if (!parsed) {
    const auto& at = parsed.error().source().begin;
    return at_line(name, at.line,
                   {ErrorCode::Invalid,
                    fmt::format("not TOML at column {}: {}", at.column, parsed.error().description())});
  }
  for (const Entry& entry : entries_of(parsed.table()))
    if (const auto taken = take(entry, settings); !taken) return at_line(name, entry.line, taken.error());
  return {};
}

std::string to_toml(const Settings& settings, const std::vector<const SettingField*>& fields) {
  std::string text;
  std::string_view table;
  for (const SettingField* field : fields) {
    if (table != table_of(field->key))
      text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", table = table_of(field->key));
    text += fmt::format("# {}\n{}\n", describe(*field), line_of(*field, settings));
  }
  return text;
}

std::string to_toml(const Settings& settings, const std::vector<SettingGroup>& groups) {
  std::vector<const SettingField*> fields;
  for (const SettingField& field : setting_fields())
    if (std::ranges::find(groups, field.group) != groups.end()) fields.push_back(&field);
  return to_toml(settings, fields);
}

}  // namespace hdrcam
