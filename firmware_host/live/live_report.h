// What a run on a camera says of itself: while it runs, in one line, and at its end. Reentrant.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/live/live_session.h"
#include "firmware_host/run_record.h"

namespace hdrcam {

struct LiveMoment {
  double seconds = 0;  // since the start
  LiveCounters counters;
  double latency_ms = 0;  // of the last emission
};

// "12.0 s  captured 360  emitted 118  dropped 240  latency 210 ms  proved 100 %".
std::string live_line(const LiveMoment& moment, bool fits);

// "captured 300 = emitted 298 + dropped 2 (2 shed, the fit was busy)", and what the camera lost.
std::string sentence_of(const LiveCounters& counters, bool fits);
// "exposures: 297 proved, 1 plausible, 0 contradicted, 2 unknown".
std::string proof_of(const CaptureCounters& camera);

// For statistics: "captured", "dropped.shed"...
std::vector<NamedValue> named(const LiveCounters& counters);

}  // namespace hdrcam
