// What tests ask of a command line that runs within this process, and of the files that it leaves. Include
// last: it brings Catch2.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "firmware_host/exit_code.h"
#include "hal/recording/recording.h"
#include "tests/support/ran_here.h"

#include "tests/contracts/expect.h"

namespace hdrcam::test {

inline void require_success(const std::vector<std::string>& words) {
  const RanHere result = ran_here(words);
  INFO(result.err);
  REQUIRE(result.exit_code == kExitOk);
}

// named: what the message must contain.
inline void check_refused(const std::vector<std::string>& words, ErrorCode code, const std::string& named) {
  const RanHere result = ran_here(words);
  INFO(result.err);
  CHECK(result.exit_code == exit_code_of(code));
  CHECK(result.err.find(named) != std::string::npos);
}

inline nlohmann::json json_in(const std::string& path) {
  return nlohmann::json::parse(value_of(read_whole(posix_storage(), path)));
}

// The whole frames of a recording, which may have been cut short.
inline std::vector<RawFrame> frames_in(const std::string& path) {
  auto reader = value_of(open_recording(posix_storage(), path));
  std::vector<RawFrame> frames;
  for (;;) {
    auto next = reader->next();
    if (!next) require_error(next, ErrorCode::Truncated);
    if (!next || !*next) return frames;
    frames.push_back(std::move(**next));
  }
}

// How many files have names that end so.
inline std::size_t files_in(const std::string& folder, const std::string& ending) {
  std::size_t count = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder))
    count += file.path().string().ends_with(ending) ? 1 : 0;
  return count;
}

}  // namespace hdrcam::test
