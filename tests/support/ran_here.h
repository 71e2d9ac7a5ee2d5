// The program as a user runs it, but within this process: on the storage of the test's choice, both streams
// apart. ran.h runs the real one. Thread-bound.
#pragma once

#include <atomic>
#include <sstream>
#include <string>
#include <vector>

#include "firmware_host/program.h"

namespace hdrcam::test {

struct RanHere {
  int exit_code = -1;
  std::string out, err;
};

// words: as a shell hands them over. stop: as a signal sets it.
inline RanHere ran_here(const std::vector<std::string>& words, Storage& storage,
                        const std::atomic<bool>& stop) {
  std::vector<const char*> args;
  for (const std::string& word : words) args.push_back(word.c_str());
  std::ostringstream out, err;
  const int exit_code = run_program(args, storage, stop, out, err);
  return {exit_code, out.str(), err.str()};
}

// stop_at_once: as if a signal had come before the first frame.
inline RanHere ran_here(const std::vector<std::string>& words, Storage& storage = posix_storage(),
                        bool stop_at_once = false) {
  const std::atomic<bool> stop{stop_at_once};
  return ran_here(words, storage, stop);
}

}  // namespace hdrcam::test
