// --trace FILE: the trace of a run, written at its end. Thread-bound.
#pragma once

#include <optional>
#include <string>

#include "firmware_host/settings/settings.h"
#include "hal/core/trace.h"
#include "hal/storage.h"

namespace hdrcam {

class TraceFile {
 public:
  explicit TraceFile(const Settings& settings) : path_(settings.machine.trace) {
    if (!path_.empty()) trace_.emplace();
  }

  Trace* trace() { return trace_ ? &*trace_ : nullptr; }  // null where none is wanted
  // After the run's threads have ended. Returns the error of the run, if it had one, else that of the disk;
  // of two the second is a warning.
  Result<void> write_after(const Result<void>& run, Storage& storage) const;

 private:
  const std::string path_;
  std::optional<Trace> trace_;
};

}  // namespace hdrcam
