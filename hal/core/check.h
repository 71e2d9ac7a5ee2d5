// HDRCAM_CHECK is for our own bugs only: it prints the operands and aborts. Failures that a user, a file or a
// device can cause are an Error (result.h).
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace hdrcam {

[[noreturn]] inline void check_failed(const char* file, int line, const char* what,
                                      const std::string& detail) {
  fmt::print(stderr, "{}:{}: bug in hdrcam: {} does not hold {}\n", file, line, what, detail);
  std::abort();
}

}  // namespace hdrcam

#define HDRCAM_CHECK(condition)                                                   \
  do {                                                                            \
    if (!(condition)) ::hdrcam::check_failed(__FILE__, __LINE__, #condition, ""); \
  } while (false)

#define HDRCAM_CHECK_COMPARE_(a, op, b)                                           \
  do {                                                                            \
    const auto check_a_ = (a);                                                    \
    const auto check_b_ = (b);                                                    \
    if (!(check_a_ op check_b_))                                                  \
      ::hdrcam::check_failed(__FILE__, __LINE__, #a " " #op " " #b,               \
                             fmt::format("({} against {})", check_a_, check_b_)); \
  } while (false)
#define HDRCAM_CHECK_EQ(a, b) HDRCAM_CHECK_COMPARE_(a, ==, b)
#define HDRCAM_CHECK_LT(a, b) HDRCAM_CHECK_COMPARE_(a, <, b)
#define HDRCAM_CHECK_LE(a, b) HDRCAM_CHECK_COMPARE_(a, <=, b)
#define HDRCAM_CHECK_GT(a, b) HDRCAM_CHECK_COMPARE_(a, >, b)

#define HDRCAM_CHECK_OK(result) \
  ((result).ok()                \
       ? (void)0                \
       : ::hdrcam::check_failed(__FILE__, __LINE__, "a result is a value", (result).error().message))
