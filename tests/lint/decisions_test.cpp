// The index of docs/decisions is written by hand: a decision that it lacks is not found again.
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "hal/storage.h"
#include "tests/contracts/expect.h"
#include "tests/places.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(HDRCAM_SOURCE_DIR) / "docs/decisions";

std::string text_of(const fs::path& path) { return value_of(read_whole(posix_storage(), path.string())); }

// What each entry that begins with its date claims, printed in bold; on one line, without a full stop.
std::vector<std::string> claims_of(const std::string& text) {
  static const std::regex kEntry(R"(\n- 20\d\d-\d\d-\d\d (?:Rejected: )?\*\*([^*]+?)[.:]?\*\*)");
  static const std::regex kSpace(R"(\s+)");
  std::vector<std::string> claims;
  for (std::sregex_iterator at(text.begin(), text.end(), kEntry), end; at != end; ++at)
    claims.push_back(std::regex_replace((*at)[1].str(), kSpace, " "));
  return claims;
}

}  // namespace

TEST_CASE("the index of decisions names each of them") {
  const std::string index = text_of(kFolder / "README.md");
  std::size_t found = 0;
  for (const auto& file : fs::directory_iterator(kFolder)) {
    if (file.path().filename() == "README.md") continue;
    CHECK(index.find("(" + file.path().filename().string() + ")") != std::string::npos);
    for (const std::string& claim : claims_of(text_of(file.path()))) {
      INFO(file.path().filename().string() << ": " << claim);
      CHECK(index.find(claim) != std::string::npos);
      ++found;
    }
  }
  CHECK(found > 200);
}
