// The index of docs/decisions is written by hand: a decision that it lacks is not found again.
#include <fmt/format.h>

#include <filesystem>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "tests/places.h"

#include "tests/support/files.h"

using namespace hdrcam;
using test::text_of;

namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(HDRCAM_SOURCE_DIR) / "docs/decisions";

// Of each entry that begins with its date: the date, and what it claims, which is printed in bold; on one
// line, without a full stop.
std::vector<std::string> claims_of(const std::string& text) {
  static const std::regex kEntry(R"(\n(- 20\d\d-\d\d-\d\d (?:Rejected: )?)\*\*([^*]+?)[.:]?\*\*)");
  static const std::regex kSpace(R"(\s+)");
  std::vector<std::string> claims;
  for (std::sregex_iterator at(text.begin(), text.end(), kEntry), end; at != end; ++at)
    claims.push_back((*at)[1].str() + std::regex_replace((*at)[2].str(), kSpace, " "));
  return claims;
}

std::size_t dated_entries_of(const std::string& text) {
  static const std::regex kDated(R"(\n- 20\d\d-)");
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), kDated), std::sregex_iterator()));
}

}  // namespace

TEST_CASE("the index of decisions names each that has a date") {
  const std::string index = text_of(kFolder / "README.md");
  std::size_t found = 0;
  for (const auto& file : fs::directory_iterator(kFolder)) {
    if (file.path().filename() == "README.md") continue;
    CHECK(index.find(fmt::format("({})", file.path().filename().string())) != std::string::npos);
    const std::string text = text_of(file.path());
    const std::vector<std::string> claims = claims_of(text);
    INFO(file.path().filename().string());
    CHECK(claims.size() == dated_entries_of(text));
    for (const std::string& claim : claims) {
      INFO(claim);
      CHECK(index.find(fmt::format("\n{}\n", claim)) != std::string::npos);
    }
    found += claims.size();
  }
  CHECK(found > 200);
}
