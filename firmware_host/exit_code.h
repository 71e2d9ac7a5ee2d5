// The exit codes of `hdrcam`: one per kind of failure, so that a script or a supervisor can tell a full disk
// from a wrong file name without reading text. The numbers are fixed: docs/exit-codes.md lists them, a test
// compares the two, and a number never gets a second meaning. Reentrant.
#pragma once

#include <optional>
#include <span>

#include "hal/core/result.h"

namespace hdrcam {

constexpr int kExitOk = 0;
constexpr int kExitInternal = 1;
constexpr int kExitUsage = 2;
constexpr int kExitInterrupted = 130;  // 128 + SIGINT, as a shell reports it

struct ExitCode {
  int number;
  // The kind of Error that ends with this number; none for success and our own bugs.
  std::optional<ErrorCode> error;
  const char* meaning;  // one clause, for the user
};

// All of them, by number.
std::span<const ExitCode> exit_codes();

int exit_code_of(ErrorCode error);

}  // namespace hdrcam
