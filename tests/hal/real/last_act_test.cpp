// What outlives a process: a program that dies here is a child of the test.
#include "hal/real/last_act.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/support/becomes_true.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

class Mark {
 public:
  Mark() : path_(fmt::format("/dev/shm/hdrcam_last_act_{}", ::getpid())) { std::filesystem::remove(path_); }
  ~Mark() { std::filesystem::remove(path_); }
  void leave() const { std::ofstream(path_) << "done"; }
  bool is_left() const { return std::filesystem::exists(path_); }
  bool appears() const {
    return test::becomes_true([this] { return is_left(); });
  }

 private:
  std::string path_;
};

// A process that prepares the act, says so, and then waits for `end`.
template <class End>
void run_and_die(const Mark& mark, End&& end) {
  int ready[2];
  REQUIRE(::pipe(ready) == 0);
  const pid_t process = ::fork();
  REQUIRE(process >= 0);
  if (process == 0) {
    ::setpgid(0, 0);
    for (const int signal : {SIGSEGV, SIGTERM}) ::signal(signal, SIG_DFL);  // not the test's own handlers
    const auto act = LastAct::prepare("hdrcam-test", [&mark] { mark.leave(); });
    (void)!::write(ready[1], act.ok() ? "y" : "n", 1);
    for (;;) ::pause();
  }
  char answer = 0;
  REQUIRE(::read(ready[0], &answer, 1) == 1);
  REQUIRE(answer == 'y');
  ::close(ready[0]), ::close(ready[1]);
  end(process);
  REQUIRE(::waitpid(process, nullptr, 0) == process);
}

TEST_CASE("a last act is done when its process is killed, or crashes") {
  for (const int signal : {SIGKILL, SIGSEGV}) {
    const Mark mark;
    run_and_die(mark, [&](pid_t process) { ::kill(process, signal); });
    INFO("signal " << signal);
    CHECK(mark.appears());
  }
}

TEST_CASE("a last act is done when the whole group of its process is told to end") {
  const Mark mark;
  run_and_die(mark, [&](pid_t process) { ::kill(-process, SIGTERM); });
  CHECK(mark.appears());
}

TEST_CASE("a last act is not done where its process goes on") {
  const Mark mark;
  {
    const auto first = value_of(LastAct::prepare("hdrcam-test", [&mark] { mark.leave(); }));
    const auto second = value_of(LastAct::prepare("hdrcam-test", [&mark] { mark.leave(); }));
  }  // both children have ended here
  CHECK_FALSE(mark.is_left());
}

}  // namespace
}  // namespace hdrcam
