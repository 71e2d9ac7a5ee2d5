// The status line of a run on a camera and the summary at its end. Reentrant.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/live/live_session.h"
#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/run_record.h"
#include "firmware_host/status_line.h"
#include "hal/core/stopwatch.h"

namespace hdrcam {

// Returns text like "12.0 s captured 360 emitted 118 dropped 240 latency 210 ms exposure proved 100 %".
std::string live_line(double elapsed_s, const LiveCounters& counters, LiveWork work);

// Shows that line on the terminal during a run. Thread-bound; the session outlives it.
class LiveStatus {
 public:
  LiveStatus(const LiveSession& session, LiveWork work) : session_(session), work_(work), line_(stderr) {}
  void update();  // when it is due

 private:
  const LiveSession& session_;
  const LiveWork work_;
  StatusLine line_;
  Stopwatch watch_;
  double elapsed_s_ = 0;
};

// "captured 300 = emitted 298 + dropped 2 (2 shed, the fit or an output was busy)", and the camera's lost
// frames.
std::string sentence_of(const LiveCounters& counters, LiveWork work);

// What gives more HDR frames where the fit or an output did not keep up, a sentence without a full stop; ""
// where all did.
std::string advice_to_keep_up(const LiveCounters& counters, const Settings& settings,
                              const RunRecord& record);

// What makes pictures contradict so many exposures of a camera, a sentence without a full stop; "" where they
// contradict few, as at the start of a run.
std::string advice_on_light(const LiveCounters& counters, const Settings& settings);

// Counters for the statistics: "captured", "dropped.shed"...
std::vector<NamedValue> named(const LiveCounters& counters);

}  // namespace hdrcam
