// Deliberate faults that still fit the tree: a patch that no longer applies proves nothing, and nobody sees
// it until all of them run for hours.
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/places.h"

#include "tests/lint/test_sources.h"
#include "tests/support/files.h"

using namespace hdrcam;
using test::text_of;

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = HDRCAM_SOURCE_DIR;

struct Mutant {
  std::string fault;
  std::vector<std::string> tests;   // that must fail
  std::string file;                 // of the tree, from its root
  std::vector<std::string> before;  // text that the fault changes, a hunk each, with the lines around it
};

Mutant parsed(const std::string& patch) {
  const auto behind = [](const std::string& line, const char* word) {
    const std::string start(word);
    return line.starts_with(start) ? line.substr(start.size()) : std::string();
  };
  Mutant mutant;
  std::istringstream lines(patch);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("@@"))
      mutant.before.emplace_back("\n");
    else if (!mutant.before.empty() && (line.starts_with(" ") || line.starts_with("-")))
      mutant.before.back() += line.substr(1) + "\n";
    else if (const auto file = behind(line, "--- a/"); !file.empty())
      mutant.file = file;
    else if (const auto fault = behind(line, "Fault: "); !fault.empty())
      mutant.fault = fault;
    else if (const auto test = behind(line, "Test: "); !test.empty())
      mutant.tests.push_back(test);
  }
  return mutant;
}

// What makes a mutant useless, a sentence each. source: of the file that it changes; tests: of all tests.
std::vector<std::string> faults_of(const Mutant& mutant, const std::string& source,
                                   const std::string& tests) {
  std::vector<std::string> found;
  if (mutant.fault.empty()) found.emplace_back("does not say what is wrong ('Fault: ..')");
  if (mutant.tests.empty()) found.emplace_back("names no test ('Test: ..')");
  for (const std::string& name : mutant.tests)
    if (!test::has_test(tests, name)) found.push_back("names the test '" + name + "', which there is not");
  if (mutant.before.empty()) found.emplace_back("changes nothing");
  for (const std::string& before : mutant.before)
    if (("\n" + source).find(before) == std::string::npos)
      found.push_back("no longer applies: '" + mutant.file + "' has no such lines:" + before);
  return found;
}

}  // namespace

TEST_CASE("every mutant still applies, names tests that there are, and stands in the table") {
  const std::string tests = test::sources_of_tests();
  const std::string table = text_of(kRoot / "tests/mutants/README.md");
  const std::size_t head = table.find("\n|---|");
  REQUIRE(head != std::string::npos);
  int mutants = 0;
  for (const auto& entry : fs::directory_iterator(kRoot / "tests/mutants")) {
    if (entry.path().extension() != ".patch") continue;
    const std::string name = entry.path().stem().string();
    const Mutant mutant = parsed(text_of(entry.path()));
    for (const std::string& fault : faults_of(mutant, text_of(kRoot / mutant.file), tests))
      FAIL_CHECK(name << " " << fault);
    const std::size_t row = table.find("\n| " + name + " |");
    if (row == std::string::npos || row < head) FAIL_CHECK(name << " is not in the table, below its head");
    ++mutants;
  }
  CHECK(mutants > 200);
}

TEST_CASE("the check of mutants finds what does not apply, and tests that there are not") {
  const Mutant mutant = parsed(
      "Fault: One is two.\nTest: one is one\n\n--- a/one.cpp\n+++ b/one.cpp\n@@ -1,2 +1,2 @@\n"
      " // One\n-int one = 1;\n+int one = 2;\n");
  CHECK(mutant.file == "one.cpp");
  const std::string tests = test::with_joined_literals("TEST_CASE(\"one \"\n    \"is one\") {");
  CHECK(faults_of(mutant, "// One\nint one = 1;\n", tests).empty());
  CHECK(faults_of(mutant, "// One\n\nint one = 1;\n", tests).size() == 1);
  CHECK(faults_of(mutant, "// Not One\nint one = 1;\n", tests).size() == 1);
  CHECK(faults_of(mutant, "// One\nint one = 1;\n", "").size() == 1);
  CHECK(faults_of({}, "", "").size() == 3);
}
