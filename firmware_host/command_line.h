// The command line as a verb sees it: the verb adds its flags and arguments, and says what to do when the
// user names it. The parser behind it is CLI11, whose header alone takes seconds to compile: only the sources
// that need more of the parser than this include it. Handles: whoever made the parser owns it, and keeps it
// for as long as they are used (Request::app). Thread-bound.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hdrcam {

// Says what a flag takes: "" for such a word, else a clause: "takes seconds, 0.001 to 60, not 'x'".
using WordCheck = std::function<std::string(const std::string&)>;

// Of a flag for a file or a folder, which takes any name. A shell hands over an empty word for "$OUT" where
// OUT is not set.
std::string names_file(const std::string& word);
// The same of a flag for a folder to write, which takes no "-" either.
std::string names_folder(const std::string& word);
// The same of what is read, which may not be "-" either: nobody reads the standard input.
std::string names_input(const std::string& word);

// A word as a shell takes it: quoted where it must be.
std::string shell_word(std::string_view word);

// A flag, or an argument without dashes. Each call returns the same flag, for the next one.
class Flag {
 public:
  explicit Flag(CLI::Option& option) : option_(&option) {}

  Flag required();
  Flag check(const WordCheck& check);
  Flag in_range(int least, int most);
  // The word becomes another one before any check.
  Flag transform(const std::function<std::string(const std::string&)>& change);

  // In --help: the value that the target has now, a placeholder for the value, a heading, another text.
  Flag show_default();
  Flag type_name(const char* placeholder);
  Flag group(const char* title);
  Flag describe(const char* help);

 private:
  CLI::Option* option_;
};

// The command line of the program, or of one of its verbs.
class CommandLine {
 public:
  CommandLine(CLI::App& parser) : parser_(&parser) {}

  CommandLine add_verb(const char* name, const char* help);
  void require_verb();  // for a verb that has verbs of its own
  void on_chosen(const std::function<void()>& action);

  // names: "-o,--output"; "recording" is an argument. The target lives as long as the parser, and keeps its
  // value unless the user gives one. A number is what parse_number() takes for one.
  Flag add_option(const char* names, std::string& target, const char* help);
  Flag add_option(const char* names, std::vector<std::string>& target, const char* help);
  Flag add_option(const char* names, int& target, const char* help);
  Flag add_option(const char* names, std::uint64_t& target, const char* help);
  Flag add_option(const char* names, double& target, const char* help);
  Flag add_switch(const char* names, bool& target, const char* help);  // takes no value
  Flag flag(const char* name);                                         // that the verb has already

  // What the user gave for this flag of the verb.
  std::optional<std::string> given(const char* name) const;

  CLI::App& parser() const { return *parser_; }

 private:
  CLI::App* parser_;
};

}  // namespace hdrcam
