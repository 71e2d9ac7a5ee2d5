#include "firmware_host/printable.h"

#include <catch2/catch.hpp>

namespace hdrcam {

TEST_CASE("control characters of a name are shown as numbers") {
  CHECK(printable("a\x1b[31m\r\n\tb\x7f") == "a\\u001B[31m\\u000D\\u000A\\u0009b\\u007F");
  CHECK(printable("\xc2\x9b") == "\\u009B");
  CHECK(printable(std::string_view("\0", 1)) == "\\u0000");
}

TEST_CASE("what turns the direction of a name, or ends its line, is shown as a number") {
  CHECK(printable("a\u202egpj.exe") == "a\\u202Egpj.exe");
  for (const char* mark :
       {"\u061c", "\u200e", "\u200f", "\u2028", "\u2029", "\u202a", "\u202e", "\u2066", "\u2069"}) {
    CAPTURE(mark);
    const std::string shown = printable(mark);
    CHECK(shown.size() == 6);
    CHECK(shown.substr(0, 2) == "\\u");
  }
}

TEST_CASE("all other characters stay, and bytes that are none") {
  for (const char* text : {"h\u00fctte", "\u05d0\u05d1", "\u00a0", "\u200d", "\u2027", "\u202f", "\u2065",
                           "\u206a", "\U0001f3a5", "\xe2\x80", "\xe2\x80x", "\xc2", "\xff\xfe", ""}) {
    CAPTURE(text);
    CHECK(printable(text) == text);
  }
}

TEST_CASE("of several lines the ends and tabs stay") {
  CHECK(printable_lines("a\tb\n\x1b\u2028c\n") == "a\tb\n\\u001B\\u2028c\n");
}

}  // namespace hdrcam
