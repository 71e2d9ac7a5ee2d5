#include "firmware_host/exit_code.h"

#include <set>
#include <string>

#include "hal/storage.h"
#include "tests/places.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr auto kLastError = ErrorCode::Interrupted;

}  // namespace

TEST_CASE("every kind of error ends with an exit code of its own") {
  std::set<int> numbers;
  for (int i = 0; i <= static_cast<int>(kLastError); ++i) {
    const int number = exit_code_of(static_cast<ErrorCode>(i));
    INFO("error code " << i);
    CHECK(number != kExitOk);
    CHECK(number != kExitInternal);
    CHECK(numbers.insert(number).second);
  }
  CHECK(exit_code_of(ErrorCode::Invalid) == kExitUsage);
  CHECK(exit_code_of(ErrorCode::Interrupted) == 130);
}

TEST_CASE("docs/exit-codes.md lists every exit code with its meaning") {
  const auto page = read_whole(posix_storage(), HDRCAM_SOURCE_DIR "/docs/exit-codes.md");
  REQUIRE(page.ok());
  for (const ExitCode& code : exit_codes()) {
    const std::string line = "| " + std::to_string(code.number) + " | " + code.meaning + " |";
    INFO(line);
    CHECK(page.value().find(line) != std::string::npos);
  }
}
