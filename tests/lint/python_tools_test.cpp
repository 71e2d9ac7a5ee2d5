// Every Python program of the tree says how it is used, or what it needs, where it is called without an
// argument.
#include <filesystem>
#include <string>

#include "tests/places.h"

#include "tests/support/files.h"
#include "tests/support/not_tested.h"
#include "tests/support/shell.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
namespace fs = std::filesystem;

TEST_CASE("a Python program of the tree that is called without an argument says what it takes") {
  if (test::shell("python3 --version").exit_code != 0) {
    NOT_TESTED("there is no python3");
    return;
  }
  int programs = 0;
  for (const char* folder : {"docs", "hal", "capture", "online", "render", "firmware_host", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(HDRCAM_SOURCE_DIR "/" + std::string(folder))) {
      const fs::path& path = entry.path();
      if (path.extension() != ".py" || !test::text_of(path).starts_with("#!")) continue;
      ++programs;
      const test::Ran said = test::shell("python3 -B '" + path.string() + "' </dev/null");
      INFO(path << ": " << said.output);
      CHECK(said.exit_code > 0);
      CHECK_THAT(said.output, Contains(path.filename().string()) && !Contains("Traceback"));
    }
  CHECK(programs > 5);
}
