// ^C as the process sees it. The program is held by a FIFO: in a system call where it is full, else by its
// own wait for a reader.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "firmware_host/exit_code.h"
#include "hal/descriptor.h"
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

// Its document goes into the FIFO.
pid_t started_into(const std::string& folder, const std::string& fifo) {
  return started({"replay", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", "--preset", "realtime", "--frames", "2",
                  "-o", folder + "/%06d.exr", "--stats", fifo, "--force"});
}

// Its reader, which takes nothing out of it.
hdrcam::Descriptor full_fifo(const std::string& fifo) {
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  hdrcam::Descriptor ends(::open(fifo.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  REQUIRE(ends.is_open());
  const std::array<char, 4096> page{};
  while (::write(ends.get(), page.data(), page.size()) > 0) {
  }
  return ends;
}

}  // namespace

TEST_CASE("the first ^C or SIGTERM only asks to stop, as does one right behind it; a later one ends it") {
  // 'timeout' sends one right behind the other.
  const std::string folder = hdrcam::sample::scratch_folder("signals"), fifo = folder + "/fifo";
  const hdrcam::Descriptor reader = full_fifo(fifo);
  for (const int signal : {SIGINT, SIGTERM}) {
    const pid_t process = started_into(folder, fifo);
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

TEST_CASE("the first ^C ends a run that waits for a program to read its FIFO") {
  const std::string folder = hdrcam::sample::scratch_folder("unread"), fifo = folder + "/fifo";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  const pid_t process = started_into(folder, fifo);
  REQUIRE(becomes_true([&] { return catches(process, SIGINT); }));
  kill(process, SIGINT);
  int status = 0;
  const bool ended = becomes_true([&] { return waitpid(process, &status, WNOHANG) == process; });
  if (!ended) kill(process, SIGKILL), waitpid(process, &status, 0);
  REQUIRE(ended);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == hdrcam::kExitInterrupted);
}

TEST_CASE("a run that is asked to stop ends with 130, and what it says is true") {
  const std::string pattern = hdrcam::sample::scratch_folder("stopped") + "/%06d.exr";
  const auto stopped = hdrcam::test::ran_here(
      {"replay", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", "-o", pattern}, hdrcam::posix_storage(), true);
  CHECK(stopped.exit_code == hdrcam::kExitInterrupted);
  CHECK(stopped.err == "hdrcam: stopped after 0 frames; the files that were written are complete.\n");
}
