// What clang 14 does not compile with the C++ library of GCC 12: the sanitizers, fuzzing and 64-bit Arm are
// built with it, the usual gate is not, so that nobody would see it.
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

bool has(const std::string& source, const char* text) { return source.find(text) != std::string::npos; }

// Algorithms that answer with a view.
std::vector<std::string> views_in(const std::string& source) {
  static const std::regex view(
      R"(std::(ranges::(rotate|find_end|search|search_n|unique|partition|stable_partition|remove|remove_if|)"
      R"(equal_range|subrange)|views::\w+)\s*[({<|])");
  std::vector<std::string> found;
  if (!has(source, "std::ranges::") && !has(source, "std::views::")) return found;
  for (std::sregex_iterator at(source.begin(), source.end(), view), end; at != end; ++at)
    found.push_back(at->str(1));
  return found;
}

std::vector<std::string> names_of(const std::string& list) {
  static const std::regex name(R"(\w+)");
  std::vector<std::string> names;
  for (std::sregex_iterator at(list.begin(), list.end(), name), end; at != end; ++at)
    names.push_back(at->str());
  return names;
}

// Structured bindings that a lambda names in its captures.
std::vector<std::string> captured_bindings_in(const std::string& source) {
  static const std::regex binding(R"(auto&{0,2} ?\[([\w, ]+)\])");
  static const std::regex capture(R"([^\w\])]\[([\w&, ]+)\]\s*\()");
  std::set<std::string> bindings;
  if (!has(source, "auto [") && !has(source, "auto& [") && !has(source, "auto&& [")) return {};
  for (std::sregex_iterator at(source.begin(), source.end(), binding), end; at != end; ++at)
    for (const std::string& name : names_of(at->str(1))) bindings.insert(name);
  std::vector<std::string> found;
  for (std::sregex_iterator at(source.begin(), source.end(), capture), end; at != end; ++at)
    for (const std::string& name : names_of(at->str(1)))
      if (bindings.contains(name)) found.push_back(name);
  return found;
}

}  // namespace

TEST_CASE("what clang 14 does not compile is found in a source") {
  CHECK(views_in("std::ranges::rotate(a, b); std::rotate(a, b, c);") ==
        std::vector<std::string>{"ranges::rotate"});
  CHECK(views_in("for (int i : std::views::iota(0, 3))") == std::vector<std::string>{"views::iota"});
  CHECK(views_in("std::ranges::sort(a); std::ranges::find_if(a, b);").empty());
  const std::string bound = "const auto [first, last] = range;\n";
  CHECK(captured_bindings_in(bound + "count(a, [first](int x) { return x < first; });") ==
        std::vector<std::string>{"first"});
  CHECK(captured_bindings_in(bound + "count(a, [&, last](int x) { return x < last; });") ==
        std::vector<std::string>{"last"});
  CHECK(captured_bindings_in(bound + "call(a[first](last), [other](int x) { return x < other; });").empty());
}

TEST_CASE("no source has what clang 14 does not compile") {
  int read = 0;
  for (const char* folder : {"hal", "capture", "online", "render", "firmware_host", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const fs::path& path = entry.path();
      if (path.extension() != ".cpp" && path.extension() != ".h") continue;
      if (path.filename() == "compilers_test.cpp") continue;
      const std::string source = text_of(path);
      for (const std::string& view : views_in(source))
        FAIL_CHECK(path.string() << ": std::" << view << "; take the algorithm of iterators");
      for (const std::string& name : captured_bindings_in(source))
        FAIL_CHECK(path.string() << ": a lambda captures '" << name
                                 << "', a structured binding; give it a name of its own");
      ++read;
    }
  CHECK(read > 1000);
}
