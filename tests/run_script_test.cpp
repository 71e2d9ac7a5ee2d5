// The front end `run` in a tree of its own, with programs of the test in place of the build, hdrcam and jq:
// where it works, what it refuses, and how it is interrupted.
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "tests/places.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shell.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::Ran;
namespace fs = std::filesystem;

namespace {

// place()/tree: a checkout in which everything is built and installed; place()/elsewhere: an empty folder.
class Checkout {
 public:
  explicit Checkout(const std::string& name) : place_(test::scratch_folder(name)) {
    for (const char* folder : {"/tree/build/release", "/tree/firmware_host", "/bin", "/elsewhere"})
      fs::create_directories(place_ + folder);
    fs::copy_file(HDRCAM_SOURCE_DIR "/run", place_ + "/tree/run");
    fs::copy(HDRCAM_SOURCE_DIR "/firmware_host/fleet", place_ + "/tree/firmware_host/fleet");
    replace("cmake", "true");
    replace("dpkg-query", "echo installed");
    // -r --arg name NAME FILTER FILE
    replace("jq", "cat \"$6\" >/dev/null && printf '%s\\t3\\t1\\t2\\n' \"$4\"");
    // replay RECORDING -o FOLDER/%06d.exr ..
    test::write_program(
        place_ + "/tree/build/release/hdrcam",
        "mkdir -p \"${4%/*}\" && echo \"$2\" >\"${4%/*}/000000.exr\"; echo '{}' >\"${4%/*}/stats.json\"");
  }

  void replace(const std::string& program, const std::string& lines) const {
    test::write_program(place_ + "/bin/" + program, lines);
  }
  // line: of a shell that stands in place()/folder.
  Ran shell(const std::string& folder, const std::string& line) const {
    return test::shell(fmt::format("cd {0}/{1} && {{ PATH={0}/bin:$PATH {2}; }}", place_, folder, line));
  }
  bool has(const std::string& file) const { return fs::exists(place_ + "/" + file); }
  std::string place() const { return place_; }

 private:
  const std::string place_;
};

}  // namespace

TEST_CASE(
    "the front end works in its own folder, by a link and beside a folder of that name that CDPATH knows") {
  const Checkout checkout("run_own_folder");
  fs::create_symlink("../tree/run", checkout.place() + "/elsewhere/hdr");
  const Ran linked = checkout.shell("elsewhere", "./hdr demo");
  INFO(linked.output);
  CHECK(linked.exit_code == 0);
  CHECK(checkout.has("tree/out/demo/000000.exr"));
  CHECK_FALSE(checkout.has("elsewhere/build"));

  fs::remove_all(checkout.place() + "/tree/out");
  fs::create_directories(checkout.place() + "/elsewhere/tree");
  const Ran beside =
      checkout.shell(".", fmt::format("CDPATH={}/elsewhere bash tree/run demo", checkout.place()));
  INFO(beside.output);
  CHECK(beside.exit_code == 0);
  CHECK(checkout.has("tree/out/demo/000000.exr"));
}

TEST_CASE("files that are named to the front end from another folder are that folder's") {
  const Checkout checkout("run_other_folder");
  std::ofstream(checkout.place() + "/elsewhere/a.mkv") << "recording";
  const Ran said = checkout.shell("elsewhere", "../tree/run fleet --plain -o out a.mkv");
  INFO(said.output);
  CHECK(said.exit_code == 0);
  CHECK(checkout.has("elsewhere/out/a/000000.exr"));
  CHECK_FALSE(checkout.has("tree/out"));
}

TEST_CASE("a verb of the front end that takes no argument refuses one and does nothing") {
  const Checkout checkout("run_no_argument");
  for (const char* verb : {"demo", "check", "package", "format"}) {
    const Ran said = checkout.shell("tree", fmt::format("./run {} quick", verb));
    CHECK(said.exit_code == 1);
    CHECK(said.output == fmt::format("run: {} takes no argument, not 'quick'\n", verb));
  }
  CHECK_FALSE(checkout.has("tree/out"));
}

TEST_CASE("a time to fuzz for that is no number of seconds is refused before anything is built") {
  const Checkout checkout("run_fuzz_seconds");
  fs::create_directories(checkout.place() + "/tree/tests/fuzz");
  std::ofstream(checkout.place() + "/tree/tests/fuzz/toml_fuzz.cpp") << "// a target\n";
  checkout.replace("cmake", "echo built");
  for (const char* seconds : {"abc", "0", "1.5", "-3", "10 more"}) {
    const Ran said = checkout.shell("tree", fmt::format("./run fuzz toml {}", seconds));
    CHECK(said.exit_code == 1);
    CHECK(said.output ==
          fmt::format("run: fuzz takes a target and whole seconds, 1 or more, not '{}'\n", seconds));
  }
}

TEST_CASE(
    "the builds of all checks are seen, packages installed without asking or not; on a build machine they "
    "are quiet") {
  const Checkout checkout("run_check_builds");
  checkout.replace("cmake", "echo \"cmake $*\"");
  for (const char* seen : {"CI= ./run check", "CI=false ./run check", "CI= ./run --yes check"}) {
    const Ran said = checkout.shell("tree", seen);
    INFO(said.output);
    CHECK_THAT(said.output, Contains("cmake --build") && !Contains("--quiet"));
  }
  const Ran quiet = checkout.shell("tree", "CI=true ./run check");
  INFO(quiet.output);
  CHECK_THAT(quiet.output, Contains("cmake --build") && Contains("--quiet"));
}

TEST_CASE("what is interrupted ends: no later check begins, and no later clip is scored") {
  const Checkout checkout("run_interrupted");
  // ^C goes to all programs of a terminal; one that handles it ends with a code of its own.
  const std::string interrupted = "trap 'exit 2' INT; kill -INT 0; exit 2",
                    alone = "env --default-signal=INT setsid --wait ";
  checkout.replace("cmake", interrupted);
  const Ran check = checkout.shell("tree", alone + "./run check");
  INFO(check.output);
  CHECK(check.exit_code == 130);
  CHECK_THAT(check.output, Contains("== ./run test") && !Contains("== ./run lint"));

  checkout.replace("hdrcam", interrupted);
  for (const char* clip : {"one", "two"}) {
    fs::create_directories(checkout.place() + "/clips/" + clip + "/gt");
    std::ofstream(checkout.place() + "/clips/" + clip + "/clip.json") << "{}";
  }
  const Ran quality = checkout.shell(
      "elsewhere", alone + "'" HDRCAM_SOURCE_DIR "/tests/quality/run_quality.sh' ../clips --hdrcam hdrcam");
  INFO(quality.output);
  CHECK(quality.exit_code == 130);
  CHECK_THAT(quality.output, Contains("one") && !Contains("two"));
}

TEST_CASE("mutants that are interrupted while a test runs end with it, and no later mutant begins") {
  const Checkout checkout("run_mutants_interrupted");
  const std::string tree = checkout.place() + "/tree", ended = checkout.place() + "/ended";
  fs::create_directories(tree + "/tests/mutants");
  fs::copy_file(HDRCAM_SOURCE_DIR "/tests/mutants/run_mutants.sh", tree + "/tests/mutants/run_mutants.sh");
  for (const char* name : {"one", "two"})
    std::ofstream(tree + "/tests/mutants/" + name + ".patch") << "Fault: a fault\nTest: a test\n--- a\n";
  checkout.replace("git", "find run tests -type f");
  checkout.replace("patch", "true");
  fs::create_directories(tree + "/build/mutants/build/release/tests");
  // ^C goes to the group of the front end, whose number is the session's; a test that hears of it says so.
  test::write_program(tree + "/build/mutants/build/release/tests/hdrcam_tests",
                      "case $1 in --list*) echo 'a test'; exit 1 ;; --abort) ;; *) exit 0 ;; esac\n"
                      "trap 'echo ended >" +
                          ended +
                          "; exit 1' TERM\n"
                          "kill -INT -$(cut -d' ' -f6 /proc/$$/stat)\nsleep 20 & wait");
  const Ran said = checkout.shell("tree", "env --default-signal=INT setsid --wait ./run mutants");
  INFO(said.output);
  CHECK(said.exit_code == 130);
  CHECK_THAT(said.output, Contains("verdict") && !Contains("two"));
  CHECK(fs::exists(ended));
}
