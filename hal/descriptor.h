// A file descriptor, closed when it goes out of scope. Move-only value.
#pragma once

#include <unistd.h>

#include <utility>

namespace hdrcam {

class Descriptor {
 public:
  Descriptor() = default;
  // Takes it over; below 0: none, as the kernel's calls answer where they fail.
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }

  int get() const { return fd_; }
  bool is_open() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

}  // namespace hdrcam
