// --trace FILE: the trace of a run, written at its end. Thread-bound.
#pragma once

#include <optional>

#include "firmware_host/settings/settings.h"
#include "hal/core/trace.h"
#include "hal/storage.h"

namespace hdrcam {

class TraceFile {
 public:
  // The settings outlive it.
  explicit TraceFile(const Settings& settings) : settings_(settings) {
    if (!settings.machine.trace.empty()) trace_.emplace();
  }

  Trace* trace() { return trace_ ? &*trace_ : nullptr; }  // null where none is wanted
  // After the run's threads have ended; lists the file where it is written. Returns the error of the run, if
  // it had one, else that of the disk; of two the second is a warning.
  Result<void> write_after(const Result<void>& run, Storage& storage) const;

 private:
  const Settings& settings_;
  std::optional<Trace> trace_;
};

}  // namespace hdrcam
