// What the package's script does on installation, with programs of the test in place of the system's.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
namespace fs = std::filesystem;

TEST_CASE("a service that does not start again does not fail the installation of the package") {
  const std::string folder = sample::scratch_folder("postinst"), calls = folder + "/calls";
  std::ifstream packaged(HDRCAM_SOURCE_DIR "/firmware_host/packaging/deb/postinst");
  std::string script(std::istreambuf_iterator<char>(packaged), {});
  const std::string booted = "/run/systemd/system";  // exists where systemd runs
  const std::size_t at = script.find(booted);
  REQUIRE(at != std::string::npos);
  script.replace(at, booted.size(), folder);
  std::ofstream(folder + "/postinst") << script;
  for (const char* program : {"systemctl", "systemd-sysusers", "udevadm"}) {
    const std::string path = folder + "/" + program;
    std::ofstream(path) << "#!/bin/sh\necho " << program << " \"$@\" >> " << calls << "\n[ " << program
                        << " != systemctl ]\n";
    fs::permissions(path, fs::perms::owner_all);
  }
  const std::string line = "PATH=" + folder + ":$PATH sh " + folder + "/postinst configure";
  CHECK(std::system(line.c_str()) == 0);
  std::ifstream called(calls);
  const std::string text(std::istreambuf_iterator<char>(called), {});
  CHECK(text.find("systemctl try-restart hdrcam.service") != std::string::npos);
}
