#include "firmware_host/terminal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace hdrcam {

void occupy_standard_streams() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd)
    if (::fcntl(fd, F_GETFD) < 0 && errno == EBADF)
      (void)::open("/dev/null",
                   fd == STDIN_FILENO ? O_RDONLY : O_WRONLY);  // gets the lowest free number, which is fd
}

}  // namespace hdrcam
