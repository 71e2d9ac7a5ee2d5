#include "tests/support/answered_ioctl.h"

#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <utility>

namespace hdrcam::test {
namespace {

thread_local const AnsweredIoctl::Answer* answering = nullptr;

}  // namespace

AnsweredIoctl::AnsweredIoctl(Answer answer) : answer_(std::move(answer)) { answering = &answer_; }
AnsweredIoctl::~AnsweredIoctl() { answering = nullptr; }

}  // namespace hdrcam::test

// Takes the place of the C library's.
extern "C" int ioctl(int fd, unsigned long request, ...) noexcept {
  std::va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  if (hdrcam::test::answering == nullptr)
    return static_cast<int>(::syscall(SYS_ioctl, fd, request, argument));
  errno = (*hdrcam::test::answering)(request, argument);
  return errno == 0 ? 0 : -1;
}
