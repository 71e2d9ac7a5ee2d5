// README.md and docs are installed without the sources around them: their links lead to each other.
#include <filesystem>
#include <regex>
#include <string>

#include "tests/places.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

namespace fs = std::filesystem;

namespace {

// Pages and pictures that firmware_host/packaging/CMakeLists.txt installs.
bool is_installed(const fs::path& path, const fs::path& root) {
  const fs::path folder = path.parent_path(), docs = root / "docs";
  if (!fs::is_regular_file(path)) return false;
  if (path.extension() == ".jpg") return folder == docs;
  return path.extension() == ".md" &&
         (path == root / "README.md" || folder == docs || folder == docs / "decisions");
}

}  // namespace

TEST_CASE("a link of README.md or of a page of docs leads to a page or picture that is installed with it") {
  const fs::path root = fs::path(HDRCAM_SOURCE_DIR).lexically_normal();
  const std::regex link(R"(\]\(([^)#\s]+)(#[^)]*)?\))");
  int links = 0;
  const auto check = [&](const fs::path& page) {
    const std::string text = hdrcam::test::text_of(page);
    for (std::sregex_iterator found(text.begin(), text.end(), link), end; found != end; ++found) {
      const std::string target = (*found)[1];
      if (target.starts_with("http")) continue;
      INFO(page << " links " << target);
      CHECK(is_installed((page.parent_path() / target).lexically_normal(), root));
      ++links;
    }
  };
  check(root / "README.md");
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") check(entry.path());
  CHECK(links > 20);
}
