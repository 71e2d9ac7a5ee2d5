// How the contract tests read a Result: the value or a failed test with the message; the expected error or a
// failed test. Include it last: Catch2's CHECK replaces ours.
#pragma once

#include <utility>

#include "hal/core/result.h"

#include <catch2/catch.hpp>

namespace hdrcam {

template <class T>
T value_of(Result<T> result) {
  if (!result.ok()) FAIL(result.error().message);
  return std::move(result).value();
}

inline void require_done(const Result<void>& result) {
  if (!result.ok()) FAIL(result.error().message);
}

template <class T>
void require_error(const Result<T>& result, ErrorCode code) {
  REQUIRE_FALSE(result.ok());
  INFO(result.error().message);
  CHECK_FALSE(result.error().message.empty());
  REQUIRE(static_cast<int>(result.error().code) == static_cast<int>(code));
}

}  // namespace hdrcam
