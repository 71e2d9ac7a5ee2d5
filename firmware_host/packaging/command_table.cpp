#include "firmware_host/packaging/command_table.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "firmware_host/settings/setting_fields.h"
#include "hal/core/split_text.h"
#include "online/knobs.h"

namespace hdrcam {
namespace {

constexpr const char* kKnobFlag = "set";

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

// Of the setting that this option sets: the one with the same name under the same heading.
std::vector<std::string> setting_words(const CLI::Option& option) {
  const std::vector<std::string>& names = option.get_lnames();
  if (names.empty()) return {};
  for (const SettingField& field : setting_fields()) {
    const std::vector<std::string> flags = parts_of(field.flag);
    const bool same = std::ranges::find(flags, "--" + names.front()) != flags.end();
    if (!same || option.get_group() != title(field.group)) continue;
    std::vector<std::string> words = field.choices;
    for (std::string& word : words)  // "vulkan:NAME" goes on after the colon
      if (const std::size_t colon = word.find(':'); colon != std::string::npos) word.resize(colon + 1);
    return words;
  }
  return {};
}

std::vector<std::string> words_of(const CLI::Option& option) {
  const std::string placeholder = option.get_type_name();
  const bool literal = std::ranges::none_of(placeholder, [](unsigned char c) { return std::isupper(c); });
  if (!placeholder.empty() && literal) {
    const std::vector<std::string_view> words = split_list(placeholder, '|');
    return {words.begin(), words.end()};
  }
  const std::vector<std::string>& names = option.get_lnames();
  if (names.empty() || names.front() != kKnobFlag) return setting_words(option);
  std::vector<std::string> words;
  for (const Knob& knob : knob_table()) words.push_back(knob.name + "=");
  return words;
}

ValueKind kind_of(const CLI::Option& option, const std::vector<std::string>& words) {
  if (option.get_items_expected_max() == 0) return ValueKind::None;
  if (!words.empty()) return ValueKind::Word;
  const std::string type = option.get_type_name();
  return type.starts_with("INT") || type.starts_with("UINT") || type.starts_with("FLOAT") ? ValueKind::Number
                                                                                          : ValueKind::Text;
}

FlagEntry entry_of(const CLI::Option& option) {
  FlagEntry entry;
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  if (option.get_positional()) entry.names = {option.get_name()};
  entry.words = words_of(option);
  entry.kind = kind_of(option, entry.words);
  if (entry.kind != ValueKind::None) entry.value = option.get_type_name();
  entry.usual = option.get_default_str();
  entry.about = one_line(option.get_description());
  entry.group = option.get_group();
  entry.required = option.get_required();
  entry.repeated = option.get_items_expected_max() > 1 ||
                   option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  return entry;
}

void add_options(const CLI::App& app, VerbEntry& verb) {
  for (const CLI::Option* option : app.get_options())
    (option->get_positional() ? verb.arguments : verb.flags).push_back(entry_of(*option));
}

// One that several of the verb's own verbs take stands once.
void add_options_of_inner(const CLI::App& inner, VerbEntry& verb) {
  for (const CLI::Option* option : inner.get_options()) {
    FlagEntry entry = entry_of(*option);
    std::vector<FlagEntry>& list = option->get_positional() ? verb.arguments : verb.flags;
    auto place = std::ranges::find(list, entry.names, &FlagEntry::names);
    if (place == list.end()) place = list.insert(list.end(), std::move(entry));
    place->inner.push_back(inner.get_name());
  }
}

// Of a verb with verbs of its own: their names come first, and their flags are its flags.
void add_inner_verbs(const std::vector<const CLI::App*>& inner, VerbEntry& verb) {
  FlagEntry which;
  which.names = {kInnerVerb}, which.kind = ValueKind::Word, which.required = true;
  for (const CLI::App* one : inner) {
    verb.inner.push_back(one->get_name());
    which.words.push_back(one->get_name());
    which.about += (which.about.empty() ? "" : "; ") + one->get_name() + ": " + one->get_description();
    which.value += (which.value.empty() ? "" : "|") + one->get_name();
  }
  for (const CLI::App* one : inner) add_options_of_inner(*one, verb);
  for (FlagEntry& argument : verb.arguments)
    argument.required = std::ranges::all_of(inner, [&](const CLI::App* one) {
      const CLI::Option* option = one->get_option_no_throw(argument.names.front());
      return option != nullptr && option->get_required();
    });
  verb.arguments.insert(verb.arguments.begin(), which);
}

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

VerbEntry entry_of(const CLI::App& app) {
  VerbEntry verb;
  verb.name = app.get_name(), verb.group = app.get_group(), verb.about = app.get_description();
  const std::string footer = app.get_footer();  // "Example:\n  hdrcam ..."
  verb.example = footer.substr(std::min(footer.size(), footer.find("hdrcam ")));
  add_options(app, verb);
  if (const auto inner = verbs_of(app); !inner.empty()) add_inner_verbs(inner, verb);
  return verb;
}

}  // namespace

CommandTable command_table(CommandLine program) {
  const CLI::App& app = program.parser();
  CommandTable table;
  table.about = one_line(app.get_description());
  for (const CLI::Option* option : app.get_options()) table.flags.push_back(entry_of(*option));
  for (const CLI::App* verb : verbs_of(app)) table.verbs.push_back(entry_of(*verb));
  return table;
}

}  // namespace hdrcam
