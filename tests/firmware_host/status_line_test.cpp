#include "firmware_host/status_line.h"

#include <pty.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <memory>
#include <string>

#include "firmware_host/terminal.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// What a terminal of 20 columns gets while write(line, master) runs; master: its other side.
template <class Write>
std::string shown_on_terminal(const Write& write) {
  int master = -1, slave = -1;
  const winsize size{24, 20, 0, 0};
  REQUIRE(openpty(&master, &slave, nullptr, nullptr, &size) == 0);
  {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> terminal(fdopen(slave, "w"), &std::fclose);
    StatusLine line(terminal.get());
    write(line, master);
  }
  std::string shown;
  char part[64];
  for (ssize_t bytes = 0; (bytes = read(master, part, sizeof part)) > 0;)  // ends with EIO: nobody writes
    shown.append(part, static_cast<std::size_t>(bytes));
  close(master);
  return shown;
}

}  // namespace

TEST_CASE("on a terminal the line is no wider than the terminal, and one line stays one line") {
  const std::string shown = shown_on_terminal([](StatusLine& line, int master) {
    line.show("frame 12/48  61 ms/frame  loss 0.021  ETA 00:03");
    line.show("short");
    line.show("frame 13/48  61 ms/frame");
    const winsize narrower{24, 10, 0, 0};
    REQUIRE(ioctl(master, TIOCSWINSZ, &narrower) == 0);
    line.show("narrower");
  });
  CHECK(shown == "\rframe 12/48  61 ms/\rshort              \rframe 13/48  61 ms/\rnarrower \r\n");
}

TEST_CASE("what is said while a line is rewritten does not stand behind it, nor leaves a line empty") {
  const std::string shown = shown_on_terminal([](StatusLine& line, int) {
    line.show("frame 1/2");
    write_remark("");  // nothing
    line.show("frame 2/2");
    write_remark("note: of the test of status lines\n");
    write_remark("note: and another\n");
  });
  CHECK(shown == "\rframe 1/2\rframe 2/2\r\n");
  const std::string again = shown_on_terminal([](StatusLine& line, int) {
    line.show("frame 1/2");
    write_remark("note: of the test of status lines\n");
    line.show("frame 2/2");
  });
  CHECK(again == "\rframe 1/2\r\n\rframe 2/2\r\n");
}
