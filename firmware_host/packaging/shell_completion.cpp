#include "firmware_host/packaging/shell_completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <string_view>

namespace hdrcam {
namespace {

std::vector<std::string> verb_names(const CommandTable& table) {
  std::vector<std::string> names;
  for (const VerbEntry& verb : table.verbs) names.push_back(verb.name);
  return names;
}

// The arguments of `hdrcam help`, which is no verb of the table.
std::vector<std::string> help_topics(const CommandTable& table) {
  std::vector<std::string> topics = verb_names(table);
  topics.emplace_back("exit-codes");
  return topics;
}

std::string with_escaped(std::string_view text, std::string_view special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

// Between single quotes, of a POSIX shell and of fish.
std::string in_quotes(std::string_view text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::vector<std::string> names_of(const std::vector<FlagEntry>& flags) {
  std::vector<std::string> names;
  for (const FlagEntry& flag : flags) names.insert(names.end(), flag.names.begin(), flag.names.end());
  return names;
}

// The flags or arguments of one of a verb's own verbs.
std::vector<FlagEntry> taken_by(const std::string& inner, const std::vector<FlagEntry>& all) {
  std::vector<FlagEntry> taken;
  std::ranges::copy_if(all, std::back_inserter(taken), [&](const FlagEntry& entry) {
    return std::ranges::find(entry.inner, inner) != entry.inner.end();
  });
  return taken;
}

std::vector<std::string> words_of(const std::vector<FlagEntry>& arguments) {
  std::vector<std::string> words;
  for (const FlagEntry& argument : arguments)
    words.insert(words.end(), argument.words.begin(), argument.words.end());
  return words;
}

// "flags='..' words='..'" of bash.
std::string bash_offer(const std::vector<FlagEntry>& flags, const std::vector<FlagEntry>& arguments) {
  return fmt::format("flags='{}' words='{}'", fmt::join(names_of(flags), " "),
                     fmt::join(words_of(arguments), " "));
}

// One branch of bash's `case`: what a verb takes, and what each of its own verbs does once it is written.
std::string bash_verb(const VerbEntry& verb) {
  std::string branch = fmt::format("        {}) {}", verb.name, bash_offer(verb.flags, verb.arguments));
  for (const std::string& inner : verb.inner)
    branch += fmt::format("\n          [ \"$inner\" != {} ] || {}", inner,
                          bash_offer(taken_by(inner, verb.flags), taken_by(inner, verb.arguments)));
  return branch + " ;;\n";
}

// One branch of bash's `case`: what follows this flag.
std::string bash_value(const std::string& verb, const FlagEntry& flag) {
  if (flag.kind == ValueKind::None) return {};
  std::string patterns;
  for (const std::string& name : flag.names)
    patterns += fmt::format("{}'{} {}'", patterns.empty() ? "" : " | ", verb, name);
  const char* act = flag.kind == ValueKind::Text ? "return" : "compopt +o default; return";
  if (flag.kind == ValueKind::Word)
    return fmt::format("    {}) words='{}' ;;\n", patterns, fmt::join(flag.words, " "));
  return fmt::format("    {}) {} ;;\n", patterns, act);
}

// What zsh's _arguments offers of these words. A word that goes on, such as "NAME=", gets no blank.
std::string zsh_words(const std::vector<std::string>& words) {
  std::vector<std::string> whole = words;
  const auto goes_on = [](const std::string& word) { return word.ends_with('=') || word.ends_with(':'); };
  const auto first = std::stable_partition(whole.begin(), whole.end(), std::not_fn(goes_on));
  const std::vector<std::string> begun(first, whole.end());
  whole.erase(first, whole.end());
  if (begun.empty()) return fmt::format("({})", fmt::join(whole, " "));
  const std::string closed = whole.empty() ? "" : fmt::format("compadd - {}; ", fmt::join(whole, " "));
  return fmt::format("{{{}compadd -S \"\" - {}}}", closed, fmt::join(begun, " "));
}

// "'[about]:value:(words)'" of zsh's _arguments, behind the names.
std::string zsh_value(const FlagEntry& flag) {
  const std::string about = with_escaped(flag.about, "[]:\\");
  std::string spec = fmt::format("[{}]", about);
  if (flag.kind == ValueKind::None) return spec;
  const std::string value = with_escaped(flag.value, ":\\");
  if (flag.kind == ValueKind::Word)
    return spec + fmt::format(":{}:{}", value, with_escaped(zsh_words(flag.words), ":"));
  return spec + fmt::format(":{}:{}", value, flag.kind == ValueKind::Text ? "_files" : "");
}

// The arguments of a verb in their order; one that may be given again is the last.
std::string zsh_arguments(const std::vector<FlagEntry>& arguments) {
  std::string specs;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const FlagEntry& argument = arguments[i];
    const std::string place = argument.repeated ? "*" : std::to_string(i + 1);
    const std::string words = fmt::format("({})", fmt::join(argument.words, " "));
    specs += fmt::format(" \\\n        '{}:{}:{}'", place, argument.names.front(),
                         argument.words.empty() ? "_files" : words);
  }
  return specs;
}

// The rest of zsh's branch of a verb, or of one of its own.
std::string zsh_offer(const std::vector<FlagEntry>& flags, const std::vector<FlagEntry>& arguments) {
  std::string offer = "_arguments -S";
  for (const FlagEntry& flag : flags) {
    const std::string both = fmt::format("{}", fmt::join(flag.names, " "));
    const std::string repeat = flag.repeated ? "*" : fmt::format("({})", both);
    for (const std::string& name : flag.names) {
      const char* attached = flag.kind == ValueKind::None ? "" : name.starts_with("--") ? "=" : "+";
      offer += fmt::format(" \\\n        {}", in_quotes(repeat + name + attached + zsh_value(flag)));
    }
  }
  return offer + zsh_arguments(arguments);
}

std::string zsh_verb(const VerbEntry& verb) {
  std::string branch = fmt::format("    {})\n", verb.name);
  for (const std::string& inner : verb.inner)
    branch += fmt::format(
        "      if (( CURRENT > 2 )) && [[ $words[2] == {} ]]; then\n"
        "        shift words\n"
        "        (( CURRENT-- ))\n"
        "        {}\n"
        "        return\n"
        "      fi\n",
        inner, zsh_offer(taken_by(inner, verb.flags), taken_by(inner, verb.arguments)));
  return branch + "      " + zsh_offer(verb.flags, verb.arguments) + " ;;\n";
}

std::string fish_flag(const std::string& condition, const FlagEntry& flag) {
  std::string line = "complete -c hdrcam -n " + in_quotes(condition);
  for (const std::string& name : flag.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (flag.kind == ValueKind::Text) line += " -r -F";
  if (flag.kind == ValueKind::Number) line += " -x";
  if (flag.kind == ValueKind::Word)
    line += " -x -a " + in_quotes(fmt::format("{}", fmt::join(flag.words, " ")));
  return line + " -d " + in_quotes(with_escaped(flag.about, "\\")) + '\n';
}

// Of fish's condition: none of these words is written.
std::string fish_unless(const std::vector<std::string>& words) {
  return words.empty() ? "" : fmt::format("; and not __fish_seen_subcommand_from {}", fmt::join(words, " "));
}

// No other of the verb's own verbs is written than those that take the flag.
std::string fish_unless_others(const VerbEntry& verb, const FlagEntry& flag) {
  std::vector<std::string> others;
  std::ranges::copy_if(verb.inner, std::back_inserter(others), [&](const std::string& inner) {
    return std::ranges::find(flag.inner, inner) == flag.inner.end();
  });
  return fish_unless(others);
}

bool takes_files(const VerbEntry& verb) {
  return std::ranges::any_of(verb.arguments,
                             [](const FlagEntry& argument) { return argument.words.empty(); });
}

}  // namespace

std::string bash_completion(const CommandTable& table) {
  std::vector<std::string> first = verb_names(table);
  first.emplace_back("help");
  for (const std::string& name : names_of(table.flags)) first.push_back(name);

  std::string values, flags;
  for (const VerbEntry& verb : table.verbs) {
    for (const FlagEntry& flag : verb.flags) values += bash_value(verb.name, flag);
    flags += bash_verb(verb);
  }
  // A word of COMP_WORDS ends at '=': "--preset=fast" is three of them.
  return fmt::format(R"(# Completion of hdrcam for bash; 'hdrcam completion bash' wrote it.
_hdrcam() {{
  local verb=${{COMP_WORDS[1]}} current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local flags= words= inner= word
  [ "$COMP_CWORD" -le 2 ] || inner=${{COMP_WORDS[2]}}
  COMPREPLY=()
  if [ "$COMP_CWORD" -le 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W '{}' -- "$current")
    return
  fi
  [ "$current" != = ] || current=
  [ "$before" != = ] || before=${{COMP_WORDS[COMP_CWORD - 2]}}
  case "$verb $before" in
{}    *)
      case "$verb" in
{}        help) [ "$COMP_CWORD" -gt 2 ] || words='{}' ;;
      esac
      for word in "${{COMP_WORDS[@]:2:COMP_CWORD - 2}}"; do
        [[ " $words " != *" $word "* ]] || words=
      done
      [[ $current != -* ]] || words=$flags ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  [[ ${{COMPREPLY[0]-}} != *= ]] || compopt -o nospace
}}
complete -o default -F _hdrcam hdrcam
)",
                     fmt::join(first, " "), values, flags, fmt::join(help_topics(table), " "));
}

std::string zsh_completion(const CommandTable& table) {
  std::string verbs, cases, globals;
  for (const VerbEntry& verb : table.verbs) {
    verbs +=
        fmt::format("    {}\n", in_quotes(fmt::format("{}:{}", verb.name, with_escaped(verb.about, ":"))));
    cases += zsh_verb(verb);
  }
  for (const FlagEntry& flag : table.flags)
    for (const std::string& name : flag.names) globals += ' ' + in_quotes(name + zsh_value(flag));
  return fmt::format(R"(#compdef hdrcam
# Completion of hdrcam for zsh; 'hdrcam completion zsh' wrote it.
_hdrcam() {{
  local -a verbs=(
{}    'help:explain a verb'
  )
  if (( CURRENT == 2 )); then
    if [[ $words[2] == -* ]]; then _arguments{}; else _describe -t verbs verb verbs; fi
    return
  fi
  shift words
  (( CURRENT-- ))
  case $words[1] in
{}    help) _arguments '1:topic:({})' ;;
  esac
}}
if [ "$funcstack[1]" = _hdrcam ]; then _hdrcam "$@"; else compdef _hdrcam hdrcam; fi
)",
                     verbs, globals, cases, fmt::join(help_topics(table), " "));
}

std::string fish_completion(const CommandTable& table) {
  std::string text =
      "# Completion of hdrcam for fish; 'hdrcam completion fish' wrote it.\n"
      "complete -c hdrcam -n __fish_use_subcommand -f\n"
      "complete -c hdrcam -n __fish_use_subcommand -a help -d 'explain a verb'\n";
  text += fmt::format(
      "complete -c hdrcam -n '__fish_seen_subcommand_from help' -f\n"
      "complete -c hdrcam -n '__fish_seen_subcommand_from help; and test (count (commandline -opc)) -eq 2' "
      "-a '{}'\n",
      fmt::join(help_topics(table), " "));
  for (const FlagEntry& flag : table.flags) text += fish_flag("__fish_use_subcommand", flag);
  for (const VerbEntry& verb : table.verbs) {
    text += fmt::format("complete -c hdrcam -n __fish_use_subcommand -a {} -d {}\n", verb.name,
                        in_quotes(with_escaped(verb.about, "\\")));
    // `help replay` names a verb, but takes none of its flags.
    const std::string here =
        fmt::format("__fish_seen_subcommand_from {}; and not __fish_seen_subcommand_from help", verb.name);
    if (!takes_files(verb)) text += fmt::format("complete -c hdrcam -n {} -f\n", in_quotes(here));
    for (const FlagEntry& flag : verb.flags) text += fish_flag(here + fish_unless_others(verb, flag), flag);
    for (const FlagEntry& argument : verb.arguments)
      if (!argument.words.empty())
        text +=
            fmt::format("complete -c hdrcam -n {} -f -a {}\n", in_quotes(here + fish_unless(argument.words)),
                        in_quotes(fmt::format("{}", fmt::join(argument.words, " "))));
  }
  return text;
}

}  // namespace hdrcam
