// What the package's scripts do on installation and removal, with programs of the test in place of the
// system's.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/shell.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

struct Said {
  int status = -1;
  std::string calls;  // of the programs, a line each
};

// A maintainer's script where systemd runs and systemctl fails.
Said script_says(const std::string& name, const std::string& argument) {
  const std::string folder = sample::scratch_folder(name), calls = folder + "/calls";
  std::ifstream packaged(HDRCAM_SOURCE_DIR "/firmware_host/packaging/deb/" + name);
  std::string script(std::istreambuf_iterator<char>(packaged), {});
  const std::string booted = "/run/systemd/system";  // exists where systemd runs
  const std::size_t at = script.find(booted);
  REQUIRE(at != std::string::npos);
  script.replace(at, booted.size(), folder);
  std::ofstream(folder + "/" + name) << script;
  for (const char* program : {"systemctl", "systemd-sysusers", "udevadm"}) {
    test::write_program(folder + "/" + program, "echo " + std::string(program) + " \"$@\" >> " + calls +
                                                    "\n[ " + program + " != systemctl ]");
  }
  const std::string line = "PATH=" + folder + ":$PATH sh " + folder + "/" + name + " " + argument;
  Said said;
  said.status = std::system(line.c_str());
  std::ifstream called(calls);
  said.calls.assign(std::istreambuf_iterator<char>(called), {});
  return said;
}

}  // namespace

TEST_CASE("a service that does not start again does not fail the installation of the package") {
  const Said said = script_says("postinst", "configure");
  CHECK(said.status == 0);
  CHECK_THAT(said.calls, Contains("systemctl try-restart hdrcam.service"));
}

TEST_CASE("devices that are there when the package is installed get the groups of its rules") {
  const std::string calls = script_says("postinst", "configure").calls;
  const std::size_t read = calls.find("udevadm control --reload"), applied = calls.find("udevadm trigger");
  REQUIRE(read != std::string::npos);
  REQUIRE(applied != std::string::npos);
  CHECK(read < applied);
  std::ifstream packaged(HDRCAM_SOURCE_DIR "/firmware_host/packaging/60-hdrcam.rules");
  const std::string rules(std::istreambuf_iterator<char>(packaged), {}), word = "SUBSYSTEM==\"";
  int subsystems = 0;
  for (std::size_t at = 0; (at = rules.find(word, at)) != std::string::npos; ++subsystems) {
    at += word.size();
    CHECK_THAT(calls, Contains("--subsystem-match=" + rules.substr(at, rules.find('"', at) - at)));
  }
  CHECK(subsystems == 4);
}

TEST_CASE("the package can be removed and replaced, though systemd does not obey") {
  for (const auto& [script, argument] :
       {std::pair{"prerm", "remove"}, {"postrm", "remove"}, {"postrm", "upgrade"}}) {
    INFO(script << " " << argument);
    const Said said = script_says(script, argument);
    CHECK(said.status == 0);
    CHECK_THAT(said.calls, Contains("systemctl "));
  }
}
