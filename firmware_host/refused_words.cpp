#include "firmware_host/refused_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "firmware_host/settings/suggestion.h"

namespace hdrcam {
namespace {

// Of "Could not convert: --skip = x".
std::string number_needed(const CLI::App& place, const std::string& sentence) {
  const std::size_t begin = sentence.find(": ") + 2, end = sentence.find(" = ", begin);
  if (end == std::string::npos) return sentence;
  const std::string name = sentence.substr(begin, end - begin);
  const CLI::Option* option = place.get_option_no_throw(name);
  if (option != nullptr && option->get_items_expected_max() == 0)
    return fmt::format("{} takes true or false, not '{}'", name, sentence.substr(end + 3));
  const bool whole = option == nullptr || !option->get_type_name().starts_with("FLOAT");
  return fmt::format("{} takes a {}number, not '{}'", name, whole ? "whole " : "", sentence.substr(end + 3));
}

std::vector<std::string> names_of_verbs(const CLI::App& place) {
  std::vector<std::string> names;
  for (const CLI::App* verb : place.get_subcommands(nullptr)) names.push_back(verb->get_name());
  return names;
}

// CLI11's words for what is wrong, in ours. Names of flags and arguments stay as the help has them.
std::string sentence_of(const CLI::App& place, const CLI::ParseError& refused) {
  std::string sentence = refused.what();
  if (sentence.starts_with("Could not convert: ")) return number_needed(place, sentence);
  if (sentence.starts_with("A subcommand is required"))
    return place.get_parent() == nullptr
               ? "no verb given"
               : fmt::format("{} needs '{}'", place.get_name(), fmt::join(names_of_verbs(place), "' or '"));
  const std::string first_word = sentence.substr(0, sentence.find_first_of(": "));
  for (const CLI::Option* option : place.get_options()) {
    const std::string name = option->get_name();
    if (name != first_word) continue;
    const std::size_t most = static_cast<std::size_t>(option->get_items_expected_max());
    if (sentence.starts_with(name + ": At Most 1") && option->count() > most)
      return option->count() == 2 ? name + " is given twice; give it once"
                                  : fmt::format("{} is given {} times; give it once", name, option->count());
    if (sentence.starts_with(name + ": 1 required")) return name + " needs a value";
    if (option->get_positional() && sentence == name + " is required")
      return fmt::format("no {} given", name);
    const std::string reason = sentence.substr(std::min(name.size() + 2, sentence.size()));
    if (reason.starts_with("takes ")) return name + ' ' + reason;
    return sentence;
  }
  if (!sentence.empty())
    sentence[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(sentence[0])));
  return sentence;
}

// The innermost verb that was named, and the words that lead to it.
struct NamedVerb {
  const CLI::App* app;
  std::string words;
};
NamedVerb innermost(const CLI::App& app) {
  NamedVerb verb{&app, app.get_name()};
  for (auto inner = app.get_subcommands(); !inner.empty(); inner = verb.app->get_subcommands()) {
    verb.app = inner.front();
    verb.words += ' ' + verb.app->get_name();
  }
  return verb;
}

// Of an argument too many: a camera without its flag, a recording in its place, one of many frames, as a
// shell makes them of "out/*.exr", or a word that is almost a verb of this one.
std::string meant_by(const std::string& word, const CLI::App& place) {
  const bool is_camera = std::ranges::any_of(std::array{"sim:", "replay:", "/dev/"},
                                             [&](const char* start) { return word.starts_with(start); });
  if (is_camera && place.get_option_no_throw("--camera") != nullptr)
    return fmt::format(" (did you mean '--camera {}'?)", word);
  if (word.ends_with(".mkv") && place.get_option_no_throw("--pace") != nullptr)  // of a recording
    return fmt::format(" (did you mean '--camera replay:{}'?)", word);
  if (word.ends_with(".exr") && place.get_option_no_throw("frames") != nullptr)
    return " (name all frames by one pattern, such as 'out/%06d.exr')";
  return did_you_mean(word, names_of_verbs(place));
}

// Adds the verbs below this one that have the flag: "replay", "bench pareto". words: that lead to them.
void add_verbs_with(const std::string& flag, const CLI::App& app, const std::string& words,
                    std::vector<std::string>& verbs) {
  for (const CLI::App* verb : app.get_subcommands(nullptr)) {
    if (verb->get_option_no_throw(flag) != nullptr) verbs.push_back(words + verb->get_name());
    add_verbs_with(flag, *verb, words + verb->get_name() + ' ', verbs);
  }
}

// Of an unknown flag, which begins the word: a file whose name begins with '-', the verbs that have the flag,
// or else one of this verb that is almost the same.
std::string meant_by_flag(const CLI::App& app, const std::string& word, const std::string& flag,
                          const std::vector<std::string>& known) {
  std::error_code none;
  if (std::filesystem::exists(word, none)) return fmt::format(" (the file is named as './{}')", word);
  std::vector<std::string> verbs;
  add_verbs_with(flag, app, "", verbs);
  return verbs.empty() ? did_you_mean(flag, known) : fmt::format(" (a flag of {})", fmt::join(verbs, ", "));
}

}  // namespace

Error not_understood(const CLI::App& app, const CLI::ParseError& refused) {
  const NamedVerb verb = innermost(app);
  const CLI::App& place = *verb.app;
  const std::string help = verb.words + " --help";
  std::vector<std::string> flags;
  for (const CLI::Option* option : place.get_options())
    for (const auto& word : option->get_lnames()) flags.push_back("--" + word);

  std::vector<std::string> extras = app.remaining(true);
  std::erase(extras, "--");  // which ends the flags, and is none
  const auto extra_flag = std::find_if(extras.begin(), extras.end(),
                                       [](const std::string& word) { return word.starts_with('-'); });
  if (extra_flag != extras.end()) {
    const std::string flag = extra_flag->substr(0, extra_flag->find('='));
    if (place.get_option_no_throw(flag) != nullptr)  // behind its verb it would have been understood
      return {ErrorCode::Invalid,
              fmt::format("flag '{}' belongs behind '{}'; see '{}'", flag, verb.words, help)};
    return {ErrorCode::Invalid, fmt::format("unknown flag '{}'{}; see '{}'", flag,
                                            meant_by_flag(app, *extra_flag, flag, flags), help)};
  }
  if (!extras.empty())
    return {ErrorCode::Invalid, fmt::format("unexpected argument '{}'{}; see '{}'", extras.front(),
                                            meant_by(extras.front(), place), help)};
  return {ErrorCode::Invalid, fmt::format("{}; see '{}'", sentence_of(place, refused), help)};
}

}  // namespace hdrcam
