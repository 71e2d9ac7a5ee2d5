#include "firmware_host/settings/suggestion.h"

#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("edits count insertions, deletions, substitutions and swaps of neighbours") {
  CHECK(edit_distance("", "") == 0);
  CHECK(edit_distance("", "seed") == 4);
  CHECK(edit_distance("seed", "sed") == 1);
  CHECK(edit_distance("seed", "feed") == 1);
  CHECK(edit_distance("seed", "sede") == 1);
  CHECK(edit_distance("replay", "repaly") == 1);
  CHECK(edit_distance("kitten", "sitting") == 3);
}

TEST_CASE("the nearest word is suggested, and none where nothing is near") {
  const std::vector<std::string> verbs{"replay", "import", "export", "info"};
  CHECK(nearest_word("repaly", verbs) == "replay");
  CHECK(nearest_word("inport", verbs) == "import");
  CHECK(nearest_word("inf", verbs) == "info");
  CHECK_FALSE(nearest_word("simulate", verbs).has_value());
  CHECK(did_you_mean("exprot", verbs) == " (did you mean 'export'?)");
  CHECK(did_you_mean("x", verbs).empty());
}

TEST_CASE("another name of a word suggests it, and no word of another meaning that is spelled alike") {
  CHECK(nearest_word("h265", std::vector<std::string>{"auto", "hevc", "av1", "h264"}) == "hevc");
  CHECK(nearest_word("gpu", std::vector<std::string>{"cpu", "vulkan", "vulkan:NAME"}) == "vulkan");
  CHECK(nearest_word("hdr", std::vector<std::string>{"pq", "hlg", "sdr"}) == "pq");
}

TEST_CASE("a number suggests no other number, which differs from it by more than its spelling") {
  CHECK_FALSE(nearest_word("55", std::vector<std::string>{"off", "50", "60"}).has_value());
  CHECK_FALSE(nearest_word("3", std::vector<std::string>{"auto", "1", "2", "4", "8"}).has_value());
  CHECK(nearest_word("50hz", std::vector<std::string>{"off", "50hz", "60hz"}) == "50hz");
}
