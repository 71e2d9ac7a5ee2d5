#include "firmware_host/terminal.h"

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

// The exit code of a short recording whose standard streams are as the shell text says.
int recorded(const std::string& file, const std::string& streams) {
  const std::string line =
      "'" HDRCAM_BINARY "' record --camera 'sim:still?size=64x48' --frames 6 -o " + file + " " + streams;
  const int status = std::system(line.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_CASE("a recording goes on whatever becomes of the terminal, and no word of it lands in the file") {
  const std::string folder = sample::scratch_folder("terminal");
  int number = 0;
  for (const auto& [streams, code] :
       {std::pair{"2>/dev/full >/dev/null", 0}, {"2>&- >&- <&-", 12}, {">/dev/full 2>/dev/null", 11}}) {
    INFO(streams);
    const std::string file = folder + "/" + std::to_string(number++) + ".mkv";
    CHECK(recorded(file, streams) == code);
    const sample::Replayed replayed = sample::replay(posix_storage(), file);
    CHECK(replayed.frames.size() == 6);
    CHECK_FALSE(replayed.error.has_value());
  }
}

TEST_CASE("results that the standard output does not take are an error in a sentence, whatever was asked") {
  const std::string demo = "'" HDRCAM_SOURCE_DIR "/tests/data/demo.mkv' ";
  const std::string words = sample::scratch_folder("terminal_results") + "/words";
  const auto ended = [&](const std::string& verb, const std::string& output) {
    const std::string line = "'" HDRCAM_BINARY "' " + verb + " 2>" + words + " " + output;
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  for (const std::string& verb :
       {std::string("--help"), std::string("--version"), std::string("help exit-codes"), "info " + demo,
        "replay " + demo + "--preset fast --emit state --frames 6 -o - --pipe-format half"}) {
    INFO(verb);
    CHECK(ended(verb, ">&-") == 12);
    CHECK_THAT(value_of(read_whole(posix_storage(), words)),
               Catch::Contains("the standard output: it is closed."));
    CHECK(ended(verb, ">/dev/full") == 11);
    CHECK_THAT(value_of(read_whole(posix_storage(), words)),
               Catch::Contains("standard output") && !Catch::Contains("files"));
  }
  CHECK(ended("export " + demo + "-o '" + words + ".frames'", ">/dev/full") == 11);
  CHECK_THAT(value_of(read_whole(posix_storage(), words)), Catch::Contains("; the files are complete"));
}

TEST_CASE("results that a program stopped to read are an error that says so") {
  const std::string folder = sample::scratch_folder("terminal_pipe"), words = folder + "/words",
                    closed = folder + "/closed";
  // the reader closes its end before the program writes
  const std::string line = "( while [ ! -e '" + closed +
                           "' ]; do sleep 0.01; done; '" HDRCAM_BINARY "' --version 2>'" + words +
                           "'; echo $? >'" + folder + "/code' ) | " + "{ exec <&-; touch '" + closed + "'; }";
  CHECK(std::system(line.c_str()) == 0);
  CHECK(value_of(read_whole(posix_storage(), folder + "/code")) == "12\n");
  CHECK(value_of(read_whole(posix_storage(), words)) ==
        "hdrcam: cannot write to the standard output: the program that reads it has ended.\n");
}

TEST_CASE(
    "frames are not written to a terminal, which would show their bytes, and no camera is opened for it") {
  const std::string words = sample::scratch_folder("terminal_frames") + "/words";
  int master = -1, slave = -1;
  REQUIRE(openpty(&master, &slave, nullptr, nullptr, nullptr) == 0);
  REQUIRE(ttyname(slave) != nullptr);
  for (const std::string& verb : {std::string("replay '" HDRCAM_SOURCE_DIR "/tests/data/demo.mkv'"),
                                  std::string("live --camera /dev/no-such-camera --shutter 1ms,4ms")}) {
    INFO(verb);
    const std::string line = "timeout 60 '" HDRCAM_BINARY "' " + verb +
                             " --preset fast --emit state --frames 6 -o - 2>'" + words + "' >'" +
                             ttyname(slave) + "'";
    const int status = std::system(line.c_str());
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 2);
    CHECK_THAT(value_of(read_whole(posix_storage(), words)), Catch::Contains("to this terminal"));
  }
  close(slave), close(master);
}

TEST_CASE("a name that would move the cursor or turn the direction of text is shown with numbers") {
  const std::string folder = sample::scratch_folder("terminal_names"), words = folder + "/words";
  const std::string line = "'" HDRCAM_BINARY "' export '" HDRCAM_SOURCE_DIR "/tests/data/demo.mkv' -o '" +
                           folder + "/a\x1b[31m\u202eb' >'" + words + "' 2>&1";
  REQUIRE(std::system(line.c_str()) == 0);
  const std::string told = value_of(read_whole(posix_storage(), words));
  CHECK_THAT(told, Catch::Contains("/a\\u001B[31m\\u202Eb: ") && !Catch::Contains("\x1b"));
}

}  // namespace
}  // namespace hdrcam
