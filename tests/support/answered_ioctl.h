// The kernel's answers to ioctl() by the test, so that code for devices runs on a machine without any: while
// one of these lives, calls of its thread go to it instead of the kernel. Thread-bound; one at a time.
#pragma once

#include <functional>

namespace hdrcam::test {

class AnsweredIoctl {
 public:
  // Returns 0 or the errno.
  using Answer = std::function<int(unsigned long request, void* argument)>;

  explicit AnsweredIoctl(Answer answer);
  ~AnsweredIoctl();
  AnsweredIoctl(const AnsweredIoctl&) = delete;
  AnsweredIoctl& operator=(const AnsweredIoctl&) = delete;

 private:
  Answer answer_;
};

}  // namespace hdrcam::test
