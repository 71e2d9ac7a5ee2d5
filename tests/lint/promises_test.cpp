// docs/robustness.md names the test that holds each promise: where the test is renamed or goes, the promise
// would stand alone, and nobody would see it.
#include <sstream>
#include <string>
#include <vector>

#include "tests/places.h"

#include "tests/lint/test_sources.h"
#include "tests/support/files.h"

using namespace hdrcam;

namespace {

// In the tables headed "| promise | test |": the tests that are named, with " · " between those of one
// promise.
std::vector<std::string> named_tests(const std::string& page) {
  const std::string kBetween = " · ";
  std::vector<std::string> names;
  std::istringstream lines(page);
  bool in_table = false;
  for (std::string line; std::getline(lines, line);) {
    if (!in_table || !line.starts_with("|")) {
      in_table = line == "| promise | test |";
      continue;
    }
    if (line.starts_with("|--")) continue;
    const std::size_t end = line.rfind(" |"), begin = line.rfind(" | ", end - 1) + 3;
    std::string rest = line.substr(begin, end - begin) + kBetween;
    for (std::size_t at; (at = rest.find(kBetween)) != std::string::npos;) {
      names.push_back(rest.substr(0, at));
      rest.erase(0, at + kBetween.size());
    }
  }
  return names;
}

}  // namespace

TEST_CASE("every test that docs/robustness.md names for a promise is there") {
  const std::string sources = test::sources_of_tests();
  const auto names = named_tests(test::text_of(HDRCAM_SOURCE_DIR "/docs/robustness.md"));
  CHECK(names.size() > 60);
  for (const std::string& name : names)
    if (!test::has_test(sources, name)) FAIL_CHECK("there is no test '" << name << "'");
}

TEST_CASE("the check of promises reads each test of a promise, and no other table") {
  CHECK(
      named_tests("| promise | test |\n|---|---|\n| one (`a|b`) | it holds · it stays |\n| two | it ends |\n"
                  "\n| size | bytes |\n|---|---|\n| small | few |\n") ==
      std::vector<std::string>{"it holds", "it stays", "it ends"});
  CHECK(test::has_test("TEST_CASE(\"it holds\")", "it holds"));
  CHECK_FALSE(test::has_test("TEST_CASE(\"it holds\")", "it hold"));
}
