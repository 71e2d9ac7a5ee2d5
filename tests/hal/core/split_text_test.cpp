#include "hal/core/split_text.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

using Parts = std::vector<std::string_view>;

TEST_CASE("a text has one part more than separators, and empty ones count") {
  CHECK(split("1ms,4ms,16ms", ',') == Parts{"1ms", "4ms", "16ms"});
  CHECK(split("a,,b,", ',') == Parts{"a", "", "b", ""});
  CHECK(split(",", ',') == Parts{"", ""});
  CHECK(split("", ',') == Parts{""});
}

TEST_CASE("a list may end with a separator, and an empty text has no part") {
  CHECK(split_list("a,b,", ',') == Parts{"a", "b"});
  CHECK(split_list("a,b", ',') == Parts{"a", "b"});
  CHECK(split_list("a,,", ',') == Parts{"a", ""});
  CHECK(split_list("", ',').empty());
}

TEST_CASE("blanks are cut from both ends of a text, and not from its middle") {
  CHECK(trimmed(" \t a b\t") == "a b");
  CHECK(trimmed("a") == "a");
  CHECK(trimmed(" \t ").empty());
  CHECK(trimmed("").empty());
  CHECK(trimmed("--a-b-", "-") == "a-b");
}

TEST_CASE("a text is cut after whole characters, of one byte to four") {
  const std::string_view text = "a\xc3\xa9\xe8\xaa\x9e\xf0\x9f\x93\xb7";  // a, e acute, a letter, a camera
  const std::size_t ends[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 10};
  for (std::size_t most = 0; most < std::size(ends); ++most)
    CHECK(first_characters(text, most) == text.substr(0, ends[most]));
  CHECK(first_characters("\x80\x80", 1).empty());
}
