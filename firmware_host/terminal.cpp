#include "firmware_host/terminal.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string>

#include "firmware_host/log_format.h"
#include "firmware_host/printable.h"

namespace hdrcam {
namespace {

std::atomic<int> lost_results_errno{0};
std::atomic<std::FILE*> open_line{nullptr};  // the stream of it

void end_line(std::FILE* stream) {
  std::fputs("\n", stream);
  std::fflush(stream);
}

// False where a part of the text did not get out. Names of files are in it, too.
bool write_to(std::FILE* stream, std::string_view lines) {
  const std::string text = printable_lines(lines);
  if (std::FILE* const rewritten = text.empty() ? nullptr : open_line.exchange(nullptr)) end_line(rewritten);
  errno = 0;
  const bool taken = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  return std::fflush(stream) == 0 && taken;
}

}  // namespace

void occupy_standard_streams() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd)
    if (::fcntl(fd, F_GETFD) < 0 && errno == EBADF)
      // Gets the lowest free number, which is fd.
      (void)::open("/dev/null", fd == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

void write_result(std::string_view text) {
  if (write_to(stdout, text)) return;
  int none = 0;
  lost_results_errno.compare_exchange_strong(none, errno != 0 ? errno : EIO);
  std::clearerr(stdout);
}

void write_remark(std::string_view text) {
  const bool plain = log_format() == LogFormat::Text;
  if (!write_to(stderr, plain ? std::string(text) : json_log_lines(text))) std::clearerr(stderr);
}

void leave_line_open(std::FILE* stream) { open_line = stream; }

void end_open_line(std::FILE* stream) {
  if (std::FILE* expected = stream; open_line.compare_exchange_strong(expected, nullptr)) end_line(stream);
}

int lost_results() { return lost_results_errno.exchange(0); }

int columns_of(std::FILE* stream) {
  winsize size{};
  return ::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

}  // namespace hdrcam
