#include "hal/supervisor.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "hal/core/parse_number.h"
#include "hal/descriptor.h"

namespace hdrcam {
namespace {

std::string_view variable(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? std::string_view() : std::string_view(text);
}

}  // namespace

Supervisor Supervisor::of_environment() {
  const std::string_view whose = variable("WATCHDOG_PID");
  const bool ours = whose.empty() || parse_number<long>(whose) == ::getpid();
  const auto patience_us = parse_number<long>(variable("WATCHDOG_USEC"));
  const Duration patience = ours && patience_us && *patience_us > 0
                                ? Duration(std::chrono::microseconds(*patience_us))
                                : Duration::zero();
  return {std::string(variable("NOTIFY_SOCKET")), patience};
}

bool Supervisor::tell(std::string_view lines) const {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_.empty() || socket_.size() >= sizeof(address.sun_path)) return false;
  std::memcpy(address.sun_path, socket_.data(), socket_.size());
  // The abstract namespace has a zero for the '@', and no zero at the end.
  const bool abstract = socket_.front() == '@';
  if (abstract) address.sun_path[0] = 0;
  const auto length =
      static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_.size() + (abstract ? 0 : 1));
  const Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket.is_open()) return false;
  return ::sendto(socket.get(), lines.data(), lines.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                  reinterpret_cast<const sockaddr*>(&address), length) >= 0;
}

}  // namespace hdrcam
