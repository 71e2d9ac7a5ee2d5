#include "hal/recording/facts_json.h"

#include <string>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

// The facts of a frame with one member as given.
std::string facts_with(const std::string& member, const std::string& value) {
  std::string text = to_json(3, FrameFacts{}, 8);
  const std::size_t key = text.find('"' + member + "\":");
  REQUIRE(key != std::string::npos);
  const std::size_t begin = key + member.size() + 3;
  return text.replace(begin, text.find_first_of(",}", begin) - begin, value);
}

TEST_CASE("a whole number of the facts that is none, or beyond its range, is refused and never converted") {
  CHECK(record_from_json(facts_with("index", "7"), 8).ok());
  for (const char* member : {"index", "sequence", "timestamp_ns", "slot", "flags"})
    for (const char* value : {"6.66e37", "1.5", "1e99", "true", "\"7\"", "99999999999999999999"}) {
      INFO(member << ' ' << value);
      require_error(record_from_json(facts_with(member, value), 8), ErrorCode::Corrupt);
    }
  require_error(record_from_json(facts_with("sequence", "-1"), 8), ErrorCode::Corrupt);
  require_error(record_from_json(facts_with("slot", "4294967296"), 8), ErrorCode::Corrupt);
  require_error(record_from_json(facts_with("flags", "4294967296"), 8), ErrorCode::Corrupt);
}

}  // namespace
}  // namespace hdrcam
