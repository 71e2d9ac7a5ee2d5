// The program in a process of its own, as a user runs it; what it says goes to a file. Thread-bound. Include
// it last: it brings Catch2.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

namespace hdrcam::hil {

// `./hdrcam ARGUMENT...`, its words going to a file.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments) {
    std::vector<const char*> words{"./hdrcam"};
    for (const std::string& argument : arguments) words.push_back(argument.c_str());
    words.push_back(nullptr);
    process_ = ::fork();
    REQUIRE(process_ >= 0);
    if (process_ > 0) return;
    const int file = ::open(kWords, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::dup2(file, STDOUT_FILENO), ::dup2(file, STDERR_FILENO);
    ::execv(words[0], const_cast<char**>(words.data()));
    ::_exit(127);
  }
  int exit_code() {
    int status = -1;
    ::waitpid(process_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void signal(int number) const { ::kill(process_, number); }
  static std::string words() {
    std::ostringstream text;
    text << std::ifstream(kWords).rdbuf();
    return text.str();
  }

 private:
  static constexpr const char* kWords = "/tmp/hdrcam.txt";
  pid_t process_ = -1;
};

}  // namespace hdrcam::hil
