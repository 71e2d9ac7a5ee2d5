#include "hal/core/json_text.h"

#include <cstdint>
#include <nlohmann/json.hpp>

#include <catch2/catch.hpp>

using namespace hdrcam;
using nlohmann::json;

TEST_CASE("JSON that nests deeper than the stack allows is not read, brackets in strings do not nest") {
  const std::string open(kDeepestJson, '['), close(kDeepestJson, ']');
  CHECK_FALSE(nests_too_deep(open + close));
  CHECK_FALSE(parsed_json<json>(open + close).is_discarded());
  CHECK(nests_too_deep("[" + open + close + "]"));
  CHECK(parsed_json<json>("[" + open + close + "]").is_discarded());
  CHECK(nests_too_deep("{\"a\":" + open + close + "}"));

  const std::string beside = "[" + std::string(500, '[') + "]";
  CHECK_FALSE(nests_too_deep("[\"" + beside + "\", \"" + beside + "\"]"));
  CHECK_FALSE(nests_too_deep(R"(["a \" )" + beside + R"("])"));  // a quote in a string does not end it
  CHECK(nests_too_deep(R"(["a \\" )" + beside + R"(])"));        // a backslash before its end does not go on
  std::string in_turn = "[";
  for (int i = 0; i < 200; ++i) in_turn += "[],";
  CHECK_FALSE(nests_too_deep(in_turn + "0]"));
}

TEST_CASE("a whole number is one that its type holds, and nothing else") {
  CHECK(whole_number<int>(json(-5)) == -5);
  CHECK(whole_number<int>(json::parse("2147483647")) == 2147483647);
  CHECK(whole_number<std::uint64_t>(json::parse("18446744073709551615")) == UINT64_MAX);
  for (const char* no_int : {"2147483648", "-2147483649", "18446744073709551615", "1.5", "3.0", "1e99",
                             "true", "null", "\"3\"", "[3]"}) {
    CAPTURE(no_int);
    CHECK_FALSE(whole_number<int>(json::parse(no_int)).has_value());
  }
  CHECK_FALSE(whole_number<std::uint64_t>(json(-1)).has_value());
}

TEST_CASE("what is no JSON is discarded") {
  CHECK(parsed_json<json>("{\"a\":").is_discarded());
  CHECK(parsed_json<json>("").is_discarded());
  CHECK(parsed_json<json>("{\"a\":1}") == json{{"a", 1}});
}

TEST_CASE("a key that one object has twice is named, the same key in two objects is not") {
  CHECK(repeated_key<json>(R"({"a":{"b":1,"c":2,"b":3}})") == "b");
  CHECK(repeated_key<json>(R"({"a":1,"b":{"a":2},"a":3})") == "a");
  CHECK_FALSE(repeated_key<json>(R"({"a":{"b":1},"b":[{"b":2},{"b":3}]})"));
  CHECK_FALSE(repeated_key<json>(R"({"a":1,"a":)"));  // no JSON at all
}

TEST_CASE("a text that is not UTF-8 is written with the sign for what cannot be shown") {
  CHECK(json_text(json("clip\xff.mkv")) == "\"clip\xef\xbf\xbd.mkv\"");
  CHECK(json_text(json{{"a", 1}}, 1) == "{\n \"a\": 1\n}");
}
