// The copyright file of the packages and the libraries that the build needs.
#include <sstream>
#include <string>

#include "tests/places.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using Catch::Contains;

TEST_CASE("the copyright file of the packages names every library that the program is made with") {
  const std::string run = hdrcam::test::text_of(HDRCAM_SOURCE_DIR "/run"), list = "packages_to_build='";
  const std::string copyright =
      hdrcam::test::text_of(HDRCAM_SOURCE_DIR "/firmware_host/packaging/deb/copyright");
  const std::size_t begin = run.find(list);
  REQUIRE(begin != std::string::npos);
  std::istringstream lines(run.substr(begin + list.size(), run.find("\n'\n", begin) - begin));
  int libraries = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::string package = line.substr(0, line.find(':'));
    if (!package.ends_with("-dev")) continue;
    CHECK_THAT(copyright, Contains(package));
    ++libraries;
  }
  CHECK(libraries > 15);
}
