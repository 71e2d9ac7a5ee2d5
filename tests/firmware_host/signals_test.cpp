// ^C as the process sees it. The program is held in a system call by a FIFO that nobody reads.
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "firmware_host/exit_code.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/becomes_true.h"
#include "tests/support/process.h"
#include "tests/support/ran_here.h"

#include <catch2/catch.hpp>

using hdrcam::test::becomes_true;
using hdrcam::test::started;
using hdrcam::test::status_word;

namespace {

bool has(pid_t process, const std::string& mask_of_status, int signal) {
  const std::string mask = status_word(process, mask_of_status);
  return !mask.empty() && (std::stoull(mask, nullptr, 16) >> (signal - 1) & 1) != 0;
}

// Whether the process has a handler for the signal now, and whether one is still to be delivered (proc(5)).
bool catches(pid_t process, int signal) { return has(process, "SigCgt:", signal); }
bool is_pending(pid_t process, int signal) { return has(process, "ShdPnd:", signal); }

}  // namespace

TEST_CASE("the first ^C or SIGTERM only asks to stop, as does one right behind it; a later one ends it") {
  // 'timeout' sends one right behind the other.
  const std::string folder = hdrcam::sample::scratch_folder("signals"), fifo = folder + "/fifo";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  for (const int signal : {SIGINT, SIGTERM}) {
    const pid_t process = started({"replay", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", "--preset", "realtime",
                                   "--frames", "1", "-o", folder + "/%06d.exr", "--stats", fifo, "--force"});
    REQUIRE(becomes_true([&] { return catches(process, signal); }));
    for (int i = 0; i < 2; ++i) {
      kill(process, signal);
      REQUIRE(becomes_true([&] { return !is_pending(process, signal); }));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(350));
    int status = 0;
    CHECK(waitpid(process, &status, WNOHANG) == 0);  // still there
    kill(process, signal);
    REQUIRE(waitpid(process, &status, 0) == process);
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == signal);
  }
}

TEST_CASE("a run that is asked to stop ends with 130, and what it says is true") {
  const std::string pattern = hdrcam::sample::scratch_folder("stopped") + "/%06d.exr";
  const auto stopped = hdrcam::test::ran_here(
      {"replay", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", "-o", pattern}, hdrcam::posix_storage(), true);
  CHECK(stopped.exit_code == hdrcam::kExitInterrupted);
  CHECK(stopped.err == "hdrcam: stopped after 0 frames; the files that were written are complete.\n");
}
