// The service manager that started the program, such as systemd: it wants to know when the program is ready,
// that it is alive, and that it ends (sd_notify(3)). One datagram of VARIABLE=value lines each, to the socket
// that it names in the environment; libsystemd would do the same with a liblzma in the process. Plain value.
// Reentrant.
#pragma once

#include <string>
#include <string_view>

#include "hal/core/instant.h"

namespace hdrcam {

class Supervisor {
 public:
  // From NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID; absent where nobody set them for this process.
  static Supervisor of_environment();
  // socket: a path, or "@NAME" in the abstract namespace; "": none.
  Supervisor(std::string socket, Duration patience) : socket_(std::move(socket)), patience_(patience) {}

  bool present() const { return !socket_.empty(); }
  // It ends the program that does not say "WATCHDOG=1" for so long; zero: it does not watch.
  Duration patience() const { return patience_; }
  // lines: "READY=1\nSTATUS=..". Never waits; a supervisor that does not listen costs the words, not the run.
  // False where it did not take them: many others wait for it, or it is not there.
  bool tell(std::string_view lines) const;

 private:
  std::string socket_;
  Duration patience_;
};

}  // namespace hdrcam
