// The service manager's end of sd_notify(3): a datagram socket that keeps what it is told. Thread-bound.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>

#include <catch2/catch.hpp>

namespace hdrcam {

class NotifySocket {
 public:
  enum class Where { Path, Abstract };

  explicit NotifySocket(Where where) {
    static std::atomic<int> count{0};
    const std::string unique = "hdrcam-notify." + std::to_string(getpid()) + "." + std::to_string(++count);
    name_ =
        where == Where::Abstract ? "@" + unique : (std::filesystem::temp_directory_path() / unique).string();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    REQUIRE(name_.size() < sizeof(address.sun_path));
    std::memcpy(address.sun_path, name_.data(), name_.size());
    if (where == Where::Abstract) address.sun_path[0] = 0;
    fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const auto length = offsetof(sockaddr_un, sun_path) + name_.size() + (where == Where::Path ? 1 : 0);
    REQUIRE(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(length)) == 0);
  }
  ~NotifySocket() {
    ::close(fd_);
    if (name_.front() != '@') std::filesystem::remove(name_);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  const std::string& name() const { return name_; }  // for NOTIFY_SOCKET

  // The next datagram; "" when none comes for so long.
  std::string next(int patience_ms = 30000) {
    pollfd wanted{fd_, POLLIN, 0};
    if (::poll(&wanted, 1, patience_ms) != 1) return {};
    std::array<char, 4096> bytes{};
    const ssize_t size = ::recv(fd_, bytes.data(), bytes.size(), 0);
    return size > 0 ? std::string(bytes.data(), static_cast<std::size_t>(size)) : std::string();
  }

 private:
  std::string name_;
  int fd_ = -1;
};

}  // namespace hdrcam
