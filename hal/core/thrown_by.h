// What a piece of work throws, kept as a value. Uncaught, an exception ends a thread of its own by
// std::terminate, and with it the program; kept, it is thrown again by whoever waits for the work. Reentrant.
#pragma once

#include <exception>
#include <utility>

namespace hdrcam {

// Null where it throws nothing.
template <class Work>
std::exception_ptr thrown_by(Work&& work) {
  try {
    std::forward<Work>(work)();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

}  // namespace hdrcam
