#include "firmware_host/status_line.h"

#include <pty.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <memory>
#include <string>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("on a terminal the line is no wider than the terminal, and one line stays one line") {
  int master = -1, slave = -1;
  winsize size{24, 20, 0, 0};
  REQUIRE(openpty(&master, &slave, nullptr, nullptr, &size) == 0);
  {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> terminal(fdopen(slave, "w"), &std::fclose);
    StatusLine line(terminal.get());
    line.show("frame 12/48  61 ms/frame  loss 0.021  ETA 00:03");
    line.show("short");
    line.show("frame 13/48  61 ms/frame");
    size.ws_col = 10;
    REQUIRE(ioctl(master, TIOCSWINSZ, &size) == 0);
    line.show("narrower");
  }
  std::string shown;
  char part[64];
  for (ssize_t bytes = 0; (bytes = read(master, part, sizeof part)) > 0;)  // ends with EIO: nobody writes
    shown.append(part, static_cast<std::size_t>(bytes));
  close(master);
  CHECK(shown == "\rframe 12/48  61 ms/\rshort              \rframe 13/48  61 ms/\rnarrower \r\n");
}
