#include "hal/real/last_act.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "hal/core/thread_name.h"

namespace hdrcam {
namespace {

// No file of the parent stays open: neither a line, nor the pipe of another LastAct, nor a terminal.
void keep_only(int file) {
  ::dup2(file, STDIN_FILENO);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  ::dup2(nothing, STDOUT_FILENO), ::dup2(nothing, STDERR_FILENO);
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
}

[[noreturn]] void wait_and_act(const std::string& name, const std::function<void()>& act, int pipe,
                               const sigset_t& signals) {
  ::setsid();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGABRT, SIGPIPE}) ::signal(signal, SIG_IGN);
  ::pthread_sigmask(SIG_SETMASK, &signals, nullptr);
  name_this_thread(name);
  keep_only(pipe);
  char dismissed = 0;
  ssize_t got = -1;
  do {
    got = ::read(STDIN_FILENO, &dismissed, 1);
  } while (got < 0 && errno == EINTR);
  if (got == 0) act();
  ::_exit(0);
}

Error cannot(const char* what) {
  const int code = errno;
  return {ErrorCode::Io,
          fmt::format("cannot {} the process that outlives this one: {}", what, std::strerror(code)), code};
}

}  // namespace

Result<std::unique_ptr<LastAct>> LastAct::prepare(const std::string& name, const std::function<void()>& act) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return cannot("make a pipe to");
  const Descriptor childs_end(ends[0]);
  Descriptor own_end(ends[1]);
  sigset_t all, before;  // no signal may end the child before it ignores them
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t child = ::fork();
  if (child == 0) {
    own_end = Descriptor();
    wait_and_act(name, act, childs_end.get(), before);
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (child < 0) return cannot("start");
  return std::unique_ptr<LastAct>(new LastAct(child, std::move(own_end)));
}

LastAct::~LastAct() {
  const char dismissed = 1;
  (void)!::write(pipe_.get(), &dismissed, 1);
  pipe_ = Descriptor();
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace hdrcam
