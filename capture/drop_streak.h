// Frames that are dropped one after the other because they are damaged or do not decode. One is a frame less;
// a camera that delivers nothing else ends the run, with what to check. Thread-bound.
#pragma once

#include <optional>
#include <string>

#include "hal/core/result.h"

namespace hdrcam {

class DropStreak {
 public:
  // A frame came through, or the camera starts anew.
  void end();
  // A frame of this camera was damaged. Errors: Corrupt once too many in a row were dropped.
  Result<void> damaged(const std::string& camera);
  // A frame did not decode. Errors: the same, with the first reason in the row; `why` itself where it is not
  // Corrupt, since a format that cannot be unpacked ends the run.
  Result<void> not_decoded(const std::string& camera, const Error& why);

 private:
  Result<void> dropped(const std::string& camera);

  int frames_ = 0;                    // in a row
  std::optional<Error> not_decoded_;  // the first reason why one of them did not decode
};

}  // namespace hdrcam
