// What systemd does with the service when the program fails.
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include "firmware_host/exit_code.h"
#include "tests/places.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

TEST_CASE(
    "the service is started again for as long as its camera is away, and not where nothing would change") {
  const std::string unit = test::text_of(HDRCAM_SOURCE_DIR "/firmware_host/packaging/hdrcam.service");
  CHECK_THAT(unit, Contains("\nRestart=on-failure\n") && Contains("\nStartLimitIntervalSec=0\n"));
  const std::string key = "\nRestartPreventExitStatus=";
  const std::size_t at = unit.find(key);
  REQUIRE(at != std::string::npos);
  std::istringstream codes(unit.substr(at + key.size(), unit.find('\n', at + 1) - at - key.size()));
  const std::set<int> lasting{std::istream_iterator<int>(codes), {}};
  for (const ErrorCode stays :
       {ErrorCode::Invalid, ErrorCode::BadExposure, ErrorCode::Unsupported, ErrorCode::Exists})
    CHECK(lasting.contains(exit_code_of(stays)));
  for (const ErrorCode awaited : {ErrorCode::NotFound, ErrorCode::Unplugged, ErrorCode::Busy,
                                  ErrorCode::Timeout, ErrorCode::Permission})
    CHECK_FALSE(lasting.contains(exit_code_of(awaited)));
}
