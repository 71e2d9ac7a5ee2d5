#include "firmware_host/packaging/shell_completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

namespace hdrcam {
namespace {

// The arguments of `hdrcam help`, which is no verb of the table.
std::vector<std::string> help_topics(const CommandTable& table) {
  std::vector<std::string> topics;
  for (const VerbEntry& verb : table.verbs) topics.push_back(verb.name);
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

// "'[about]:value:(words)'" of zsh's _arguments, behind the names.
std::string zsh_value(const FlagEntry& flag) {
  const std::string about = with_escaped(flag.about, "[]:\\");
  std::string spec = fmt::format("[{}]", about);
  if (flag.kind == ValueKind::None) return spec;
  const std::string value = with_escaped(flag.value, ":\\");
  if (flag.kind == ValueKind::Word)
    return spec +
           fmt::format(":{}:({})", value, with_escaped(fmt::format("{}", fmt::join(flag.words, " ")), ":"));
  return spec + fmt::format(":{}:{}", value, flag.kind == ValueKind::Text ? "_files" : "");
}

// The arguments of a verb in their order; the last one may be given again.
std::string zsh_arguments(const std::vector<FlagEntry>& arguments) {
  std::string specs;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const FlagEntry& argument = arguments[i];
    const std::string place = i + 1 < arguments.size() ? std::to_string(i + 1) : "*";
    const std::string words = fmt::format("({})", fmt::join(argument.words, " "));
    specs += fmt::format(" \\\n        '{}:{}:{}'", place, argument.names.front(),
                         argument.words.empty() ? "_files" : words);
  }
  return specs;
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

}  // namespace

std::string bash_completion(const CommandTable& table) {
  std::vector<std::string> first = help_topics(table);
  first.back() = "help";
  for (const std::string& name : names_of(table.flags)) first.push_back(name);

  std::string values, flags;
  for (const VerbEntry& verb : table.verbs) {
    for (const FlagEntry& flag : verb.flags) values += bash_value(verb.name, flag);
    std::vector<std::string> arguments;
    for (const FlagEntry& argument : verb.arguments)
      arguments.insert(arguments.end(), argument.words.begin(), argument.words.end());
    flags += fmt::format("        {}) flags='{}' words='{}' ;;\n", verb.name,
                         fmt::join(names_of(verb.flags), " "), fmt::join(arguments, " "));
  }
  // A word of COMP_WORDS ends at '=': "--preset=fast" is three of them.
  return fmt::format(R"(# Completion of hdrcam for bash; 'hdrcam completion bash' wrote it.
_hdrcam() {{
  local verb=${{COMP_WORDS[1]}} current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local flags= words=
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
{}        help) words='{}' ;;
      esac
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
    cases += fmt::format("    {})\n      _arguments -S", verb.name);
    for (const FlagEntry& flag : verb.flags) {
      const std::string both = fmt::format("{}", fmt::join(flag.names, " "));
      const std::string repeat = flag.repeated ? "*" : fmt::format("({})", both);
      for (const std::string& name : flag.names) {
        const bool long_name = name.starts_with("--") && flag.kind != ValueKind::None;
        cases += fmt::format(" \\\n        {}",
                             in_quotes(repeat + name + (long_name ? "=" : "") + zsh_value(flag)));
      }
    }
    cases += zsh_arguments(verb.arguments) + " ;;\n";
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
{}    help) _values topic {} ;;
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
  text += fmt::format("complete -c hdrcam -n '__fish_seen_subcommand_from help' -f -a '{}'\n",
                      fmt::join(help_topics(table), " "));
  for (const FlagEntry& flag : table.flags) text += fish_flag("__fish_use_subcommand", flag);
  for (const VerbEntry& verb : table.verbs) {
    text += fmt::format("complete -c hdrcam -n __fish_use_subcommand -a {} -d {}\n", verb.name,
                        in_quotes(with_escaped(verb.about, "\\")));
    // `help replay` names a verb, but takes none of its flags.
    const std::string here =
        fmt::format("__fish_seen_subcommand_from {}; and not __fish_seen_subcommand_from help", verb.name);
    for (const FlagEntry& flag : verb.flags) text += fish_flag(here, flag);
    for (const FlagEntry& argument : verb.arguments)
      if (!argument.words.empty())
        text += fmt::format("complete -c hdrcam -n {} -f -a {}\n", in_quotes(here),
                            in_quotes(fmt::format("{}", fmt::join(argument.words, " "))));
  }
  return text;
}

}  // namespace hdrcam
