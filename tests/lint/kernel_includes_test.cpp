// What a *_kernels.cpp may include: it is compiled once per instruction set (hdrcam_kernels() in
// CMakeLists.txt), and of inline code in a header the linker keeps one copy for the whole program, which may
// have instructions that this processor lacks.
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/places.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

namespace {

namespace fs = std::filesystem;
using hdrcam::test::text_of;

const fs::path kRoot = HDRCAM_SOURCE_DIR;

std::vector<std::string> matches_in(const std::string& source, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator at(source.begin(), source.end(), pattern), end; at != end; ++at)
    found.push_back(at->str(1));
  return found;
}

// Headers of a library that have more than types and intrinsics, and functions with a body. What is in the
// namespace of an instruction set, and there in one without a name, nobody shares.
std::vector<std::string> shared_code_in(const std::string& source) {
  static const std::regex library(R"(#include <([^>]+)>)"), body(R"((\w+)\([^()]*\)(?: const)? \{)");
  static const std::set<std::string> kTypesAlone{"arm_neon.h", "cstddef", "cstdint"};
  std::vector<std::string> found;
  for (const std::string& header : matches_in(source, library))
    if (!kTypesAlone.contains(header)) found.push_back(header);
  if (source.find("HDRCAM_TARGET") != std::string::npos) return found;
  for (const std::string& function : matches_in(source, body)) found.push_back(function);
  return found;
}

// The file and what it includes of ours, itself or through others.
void note_reached(const std::string& file, std::set<std::string>& reached) {
  static const std::regex ours(R"re(#include "([^"]+)")re");
  if (!reached.insert(file).second) return;
  for (const std::string& included : matches_in(text_of(kRoot / file), ours)) note_reached(included, reached);
}

}  // namespace

TEST_CASE("code that a kernel would share is found in a header") {
  using Found = std::vector<std::string>;
  CHECK(shared_code_in("#include <algorithm>\n#include <cstdint>\n") == Found{"algorithm"});
  CHECK(shared_code_in("inline int twice(int x) { return 2 * x; }\n") == Found{"twice"});
  CHECK(shared_code_in("struct Row {\n  int half() const { return n / 2; }\n  int n;\n};\n") ==
        Found{"half"});
  CHECK(shared_code_in("inline constexpr Limits kWide{3, 250};\nvoid fill(Row& row, int n);\n"
                       "struct Table {\n  void (*fill)(Row&, int n);\n};\nconst Table& table();\n")
            .empty());
  CHECK(shared_code_in("namespace hdrcam::HDRCAM_TARGET {\nnamespace {\n"
                       "inline int twice(int x) { return 2 * x; }\n}\n}\n")
            .empty());
}

TEST_CASE("no kernel includes code that another file might share") {
  int kernels = 0;
  for (const char* folder : {"hal", "capture", "online", "render", "firmware_host"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string kernel = fs::relative(entry.path(), kRoot).generic_string();
      if (!kernel.ends_with("_kernels.cpp")) continue;
      std::set<std::string> reached;
      note_reached(kernel, reached);
      for (const std::string& file : reached)
        for (const std::string& code : shared_code_in(text_of(kRoot / file)))
          FAIL_CHECK(kernel << " reaches " << file << ", which has '" << code << "'");
      ++kernels;
    }
  CHECK(kernels > 8);
}
