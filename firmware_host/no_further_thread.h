// What the program says where std::thread finds the limit of processes: std::system_error with
// resource_unavailable_try_again. Reentrant.
#pragma once

#include "hal/core/result.h"

namespace hdrcam {

inline Error no_further_thread() {
  return {ErrorCode::Io,
          "the system starts no further thread; raise the limit of processes (ulimit -u, or TasksMax of a "
          "service), or end other programs"};
}

}  // namespace hdrcam
