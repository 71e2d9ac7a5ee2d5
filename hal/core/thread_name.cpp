#include "hal/core/thread_name.h"

#include <pthread.h>

#include <array>

namespace hdrcam {
namespace {

constexpr std::size_t kMostBytes = 15;  // the kernel's limit

}  // namespace

void name_this_thread(const std::string& name) {
  (void)pthread_setname_np(pthread_self(), name.substr(0, kMostBytes).c_str());
}

std::string name_of_this_thread() {
  std::array<char, kMostBytes + 1> name{};
  (void)pthread_getname_np(pthread_self(), name.data(), name.size());
  return name.data();
}

}  // namespace hdrcam
