// The program as a user runs it: a command line in, its end and both streams out. Include last: it brings
// Catch2.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/command_line.h"
#include "tests/places.h"
#include "tests/support/shell.h"

#include <catch2/catch.hpp>

namespace hdrcam::test {

// arguments: as a shell takes them; before: what stands before the program, such as an environment.
inline Ran ran(const std::string& arguments, const std::string& before = "") {
  return shell(before + " '" HDRCAM_BINARY "' " + arguments);
}
inline Ran ran(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += shell_word(word) + " ";
  return ran(line);
}

}  // namespace hdrcam::test
