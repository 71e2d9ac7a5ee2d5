// README.md shows a few tables of figures, and pages of docs explain them with the commands that make them. A
// figure that is measured again and changed in one of them alone would leave two truths.
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/places.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::text_of;

namespace fs = std::filesystem;

namespace {

const fs::path kRoot = HDRCAM_SOURCE_DIR;

// The rows of all tables from the line `begin` on to the line `end`, without the lines below their heads.
std::vector<std::string> rows_between(const std::string& page, const std::string& begin,
                                      const std::string& end) {
  std::vector<std::string> rows;
  std::istringstream lines(page);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line == begin) inside = true;
    if (line == end) inside = false;
    if (inside && line.starts_with("|") && !line.starts_with("|--")) rows.push_back(line);
  }
  return rows;
}

}  // namespace

TEST_CASE("each row of figures in README.md stands in the page of docs that explains it, too") {
  std::string pages;
  for (const char* page : {"quality.md", "real-time.md", "robustness.md"})
    pages += text_of(kRoot / "docs" / page);
  const auto rows = rows_between(text_of(kRoot / "README.md"), "## What to expect", "## Where things are");
  CHECK(rows.size() > 20);
  for (const std::string& row : rows) {
    INFO(row);
    CHECK(pages.find("\n" + row + "\n") != std::string::npos);
  }
}

TEST_CASE("README.md lists every page of docs") {
  const std::string readme = text_of(kRoot / "README.md");
  int pages = 0;
  for (const auto& entry : fs::directory_iterator(kRoot / "docs")) {
    if (entry.path().extension() != ".md") continue;
    const std::string page = "docs/" + entry.path().filename().string();
    INFO(page);
    CHECK(readme.find(fmt::format("\n| [{0}]({0}) | ", page)) != std::string::npos);
    ++pages;
  }
  CHECK(pages > 15);
}

TEST_CASE("the rows between two headings are those of their tables, heads included") {
  CHECK(rows_between("| a | b |\n## Figures\n| c | d |\n|---|---|\n| 1 | 2 |\nwords\n## Next\n| e |\n",
                     "## Figures", "## Next") == std::vector<std::string>{"| c | d |", "| 1 | 2 |"});
}
