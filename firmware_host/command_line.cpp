#include "firmware_host/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "hal/core/parse_number.h"

namespace hdrcam {
namespace {

// Numbers are what settings and files take for them (parse_number.h): CLI11 alone takes 010 for eight, and
// 0x5, +5 and blanks besides.
template <class Number>
Flag add_number(CLI::App& parser, const char* names, Number& target, const char* help) {
  const auto take = [&target](const CLI::results_t& words) {
    const auto number = parse_number<Number>(words.front());
    if (number) target = *number;
    return number.has_value();
  };
  const auto usual = [&target] { return fmt::format("{}", target); };
  return Flag(
      *parser.add_option(names, take, help, false, usual)->type_name(CLI::detail::type_name<Number>()));
}

}  // namespace

std::string names_file(const std::string& word) {
  return word.empty() ? "takes the name of a file or a folder, not ''" : "";
}

std::string names_folder(const std::string& word) {
  return word == "-" ? "takes the name of a folder, not '-', the standard output" : names_file(word);
}

std::string names_input(const std::string& word) {
  return word == "-" ? "takes the name of a file, not '-': the standard input is not read" : names_file(word);
}

std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789%+,-./:=@_";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  }
  return quoted + "'";
}

Flag Flag::required() { return Flag(*option_->required()); }

Flag Flag::check(const WordCheck& check) { return Flag(*option_->check(check)); }

Flag Flag::in_range(int least, int most) {
  option_->description(fmt::format("{} ({}..{})", option_->get_description(), least, most));
  return check([least, most](const std::string& word) {
    const auto number = parse_number<int>(word);
    return number && *number >= least && *number <= most
               ? std::string()
               : fmt::format("takes a whole number, {} to {}, not '{}'", least, most, word);
  });
}

Flag Flag::transform(const std::function<std::string(const std::string&)>& change) {
  return Flag(*option_->transform(change));
}

Flag Flag::show_default() { return Flag(*option_->capture_default_str()); }

Flag Flag::type_name(const char* placeholder) { return Flag(*option_->type_name(placeholder)); }

Flag Flag::group(const char* title) { return Flag(*option_->group(title)); }

Flag Flag::describe(const char* help) { return Flag(*option_->description(help)); }

CommandLine CommandLine::add_verb(const char* name, const char* help) {
  return *parser_->add_subcommand(name, help);
}

void CommandLine::require_verb() { parser_->require_subcommand(1); }

void CommandLine::on_chosen(const std::function<void()>& action) { parser_->callback(action); }

Flag CommandLine::add_option(const char* names, std::string& target, const char* help) {
  return Flag(*parser_->add_option(names, target, help));
}

Flag CommandLine::add_option(const char* names, std::vector<std::string>& target, const char* help) {
  CLI::Option* const option = parser_->add_option(names, target, help);
  if (option->nonpositional())
    option->allow_extra_args(false);  // one value each time; the next word is another's
  return Flag(*option);
}

Flag CommandLine::add_option(const char* names, int& target, const char* help) {
  return add_number(*parser_, names, target, help);
}

Flag CommandLine::add_option(const char* names, std::uint64_t& target, const char* help) {
  return add_number(*parser_, names, target, help);
}

Flag CommandLine::add_option(const char* names, double& target, const char* help) {
  return add_number(*parser_, names, target, help);
}

Flag CommandLine::add_switch(const char* names, bool& target, const char* help) {
  return Flag(*parser_->add_flag(names, target, help));
}

Flag CommandLine::flag(const char* name) { return Flag(*parser_->get_option(name)); }

std::optional<std::string> CommandLine::given(const char* name) const {
  const CLI::Option* const option = parser_->get_option_no_throw(name);
  if (option == nullptr || option->count() == 0) return std::nullopt;
  return option->as<std::string>();
}

}  // namespace hdrcam
