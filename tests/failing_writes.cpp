// Preloaded into the program by tests/firmware_host/commands/failing_writes_test.cpp: of all calls that write
// to a regular file, one fails. In the environment, HDRCAM_FAILING_WRITE is its number, from 0, and the
// fault: "12 ENOSPC", also EIO, EINTR and SHORT (half of the bytes are written); HDRCAM_WRITES_COUNTED names
// a file for the number of calls there were.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace {

struct Fault {
  long at = -1;
  int error = 0;  // 0: a short write
};

Fault asked_fault() {
  Fault fault;
  char kind[16] = "";
  const char* const text = std::getenv("HDRCAM_FAILING_WRITE");
  if (text == nullptr || std::sscanf(text, "%ld %15s", &fault.at, kind) != 2) return {};
  if (std::strcmp(kind, "ENOSPC") == 0) fault.error = ENOSPC;
  if (std::strcmp(kind, "EIO") == 0) fault.error = EIO;
  if (std::strcmp(kind, "EINTR") == 0) fault.error = EINTR;
  return fault;
}

std::atomic<long> calls{0};

// How many bytes this call may write; none: it fails, and errno says why.
std::optional<std::size_t> let_through(int fd, std::size_t bytes) {
  static const Fault fault = asked_fault();
  struct stat status {};
  if (fd < 3 || fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) return bytes;
  if (calls++ != fault.at) return bytes;
  if (fault.error == 0) return bytes > 1 ? bytes / 2 : bytes;
  errno = fault.error;
  return std::nullopt;
}

struct AtExit {
  ~AtExit() {
    const char* const path = std::getenv("HDRCAM_WRITES_COUNTED");
    if (path == nullptr) return;
    char text[32];
    const int n = std::snprintf(text, sizeof text, "%ld", calls.load());
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) return;
    (void)syscall(SYS_write, fd, text, static_cast<std::size_t>(n));
    close(fd);
  }
} at_exit;

}  // namespace

extern "C" {

__attribute__((visibility("default"))) ssize_t write(int fd, const void* bytes, std::size_t count) {
  const auto some = let_through(fd, count);
  return some ? syscall(SYS_write, fd, bytes, *some) : -1;
}
__attribute__((visibility("default"))) ssize_t pwrite64(int fd, const void* bytes, std::size_t count,
                                                        off64_t at) {
  const auto some = let_through(fd, count);
  return some ? syscall(SYS_pwrite64, fd, bytes, *some, at) : -1;
}
__attribute__((visibility("default"))) ssize_t pwrite(int fd, const void* bytes, std::size_t count,
                                                      off_t at) {
  return pwrite64(fd, bytes, count, at);
}

}  // extern "C"
