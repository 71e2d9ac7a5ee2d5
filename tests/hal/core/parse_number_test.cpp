#include "hal/core/parse_number.h"

#include <cstdint>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a number is the whole of its text, and nothing else") {
  CHECK(parse_number<int>("-12") == -12);
  CHECK(parse_number<double>("2.5e-3") == 2.5e-3);
  CHECK(parse_number<std::uint64_t>("18446744073709551615") == UINT64_MAX);
  for (const char* wrong : {"", " 1", "1 ", "+1", "1,5", "0x10", "1s", "-", "e"}) {
    INFO(wrong);
    CHECK_FALSE(parse_number<int>(wrong));
    CHECK_FALSE(parse_number<double>(wrong));
  }
  CHECK_FALSE(parse_number<int>("2.5"));
  CHECK_FALSE(parse_number<int>("2147483648"));
  CHECK_FALSE(parse_number<std::uint16_t>("65536"));
  CHECK_FALSE(parse_number<std::uint16_t>("-1"));
}

TEST_CASE("infinity and no number are not read as numbers") {
  for (const char* wrong : {"inf", "-inf", "nan", "infinity", "1e999"}) {
    INFO(wrong);
    CHECK_FALSE(parse_number<double>(wrong));
    CHECK_FALSE(parse_number<float>(wrong));
  }
}
