// The command line as data: every verb with its flags, arguments and their words, read from the parser.
// Manual pages and completions are written from it, so neither can name a flag that the program does not
// take. Plain values. Reentrant.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/command_line.h"

namespace hdrcam {

// What follows a flag: nothing, one of its words, a number, or a text, which often is a file.
enum class ValueKind { None, Word, Number, Text };

// A flag, or an argument without one.
struct FlagEntry {
  std::vector<std::string> names;  // "-o", "--output"; of an argument: "recording"
  ValueKind kind = ValueKind::None;
  std::string value;               // placeholder of the value: "INT"
  std::string usual;               // default, "" for none
  std::vector<std::string> words;  // where they are known; one that ends in '=' or ':' goes on
  std::string about, group;        // group: the heading in --help, "Output"
  bool required = false;
  bool repeated = false;           // may be given again, with another value
  std::vector<std::string> inner;  // of VerbEntry::inner: those that take it
};

struct VerbEntry {
  std::string name, group, about, example;
  std::vector<std::string> inner;           // the names of its own verbs, where it has some
  std::vector<FlagEntry> flags, arguments;  // also those of its own verbs
};

// The argument of a verb that has verbs of its own: "bench pareto".
constexpr const char* kInnerVerb = "what";

struct CommandTable {
  std::string about;
  std::vector<FlagEntry> flags;  // without a verb
  std::vector<VerbEntry> verbs;  // in the order of --help
};

// program: as program.cpp builds it. A placeholder in lower case lists an option's words: "bash|zsh|fish".
CommandTable command_table(CommandLine program);

}  // namespace hdrcam
