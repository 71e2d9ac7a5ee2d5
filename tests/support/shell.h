// Command lines in a shell, and programs of a test that stand in for others in its path. Include last: it
// brings Catch2.
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>

namespace hdrcam::test {

struct Ran {
  int exit_code = -1;  // -1: ended by a signal
  std::string output;  // both streams
};

// line: without a redirection of its errors.
inline Ran shell(const std::string& line) {
  std::FILE* const pipe = ::popen((line + " 2>&1").c_str(), "r");
  REQUIRE(pipe != nullptr);
  Ran ran;
  char block[512];
  while (const std::size_t n = std::fread(block, 1, sizeof block, pipe)) ran.output.append(block, n);
  const int status = ::pclose(pipe);
  if (WIFEXITED(status)) ran.exit_code = WEXITSTATUS(status);
  return ran;
}

// lines: of the program, as a shell takes them.
inline void write_program(const std::string& path, const std::string& lines) {
  std::ofstream(path) << "#!/bin/sh\n" << lines << "\n";
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
}

}  // namespace hdrcam::test
