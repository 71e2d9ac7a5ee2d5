// The program as a process of its own, silent, for tests that send it signals or look at it from outside.
// ran.h waits for its end. Include last: it brings Catch2.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/places.h"

#include <catch2/catch.hpp>

namespace hdrcam::test {

// words: what follows the program's name. Returns once the program itself runs, with no handler of this
// process left in it.
inline pid_t started(std::vector<std::string> words) {
  std::string program = HDRCAM_BINARY;
  std::vector<char*> argv{program.data()};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t silent;
  posix_spawn_file_actions_init(&silent);
  for (const int stream : {1, 2}) posix_spawn_file_actions_addopen(&silent, stream, "/dev/null", O_WRONLY, 0);
  pid_t process = -1;
  REQUIRE(posix_spawn(&process, argv.front(), &silent, nullptr, argv.data(), environ) == 0);
  posix_spawn_file_actions_destroy(&silent);
  return process;
}

// The first word of a field of proc(5)'s status, such as "VmHWM:"; empty once the process has ended.
inline std::string status_word(pid_t process, const std::string& field) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string word; status >> word;)
    if (word == field) return status >> word, word;
  return "";
}

}  // namespace hdrcam::test
