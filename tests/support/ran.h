// The program as a user runs it: a command line in, its end and both streams out. Include last: it brings
// Catch2.
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <string>
#include <vector>

#include "firmware_host/settings/settings_flags.h"
#include "tests/places.h"

#include <catch2/catch.hpp>

namespace hdrcam::test {

struct Ran {
  int exit_code = -1;  // -1: ended by a signal
  std::string output;  // both streams
};

// arguments: as a shell takes them; before: what stands before the program, such as an environment.
inline Ran ran(const std::string& arguments, const std::string& before = "") {
  std::FILE* pipe = popen((before + " '" HDRCAM_BINARY "' " + arguments + " 2>&1").c_str(), "r");
  REQUIRE(pipe != nullptr);
  Ran ran;
  char buffer[512];
  while (const std::size_t n = fread(buffer, 1, sizeof buffer, pipe)) ran.output.append(buffer, n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ran.exit_code = WEXITSTATUS(status);
  return ran;
}
inline Ran ran(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += shell_word(word) + " ";
  return ran(line);
}

}  // namespace hdrcam::test
