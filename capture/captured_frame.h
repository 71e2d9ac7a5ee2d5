// A frame with the judgement of its exposure, as CaptureStage (capture_stage.h) or RecordingStage
// (recording_stage.h) delivers it, and the counters of all frames. Plain values.
#pragma once

#include <cstdint>
#include <string>

#include "capture/exposure_advice.h"
#include "capture/exposure_proof.h"
#include "capture/trigger_ledger.h"
#include "hal/core/frame.h"

namespace hdrcam {

// Counts of frames by outcome. At every moment captured = emitted + dropped().
struct CaptureCounters {
  std::uint64_t captured = 0;  // delivered by the camera or the recording
  std::uint64_t emitted = 0;
  std::uint64_t damaged = 0;         // dropped: the driver reports incomplete pixels
  std::uint64_t undecodable = 0;     // dropped: too short, or a JPEG that does not decode
  std::uint64_t lost_by_camera = 0;  // never captured: gaps in sequence numbers and timestamps
  std::uint64_t proved = 0, plausible = 0, estimated = 0, contradicted = 0, unknown = 0;  // of the emitted
  std::uint64_t relabelled = 0;  // among the plausible: by the pictures alone
  std::uint64_t unreported = 0;  // frames whose exposure the driver did not report
  std::uint64_t repeated_cookies = 0;
  std::uint64_t strobed = 0;           // frames matched with a pulse of the strobe line
  std::uint64_t strobe_misfits = 0;    // of them: its width refuses the stated exposure, or none is trusted
  std::uint64_t triggered = 0;         // frames matched with a pulse of the trigger line
  std::uint64_t pulses_forgotten = 0;  // frames taken so late that their strobe or trigger pulse was not kept
  std::uint64_t controls_late = 0;     // frames whose exposure was written late or never
  std::uint64_t requests_late = 0;     // no free buffer when a request was due
  std::uint64_t relocks = 0;           // times the prediction found the cadence again
  std::uint64_t cycle_changes = 0;     // to follow the light, or what the fit asked for
  TriggerCounters trigger;

  std::uint64_t dropped() const { return damaged + undecodable; }
  void count(const Judgement& judgement);  // of an emitted frame
};

// Returns text like "exposures: 297 proved, 1 plausible, 0 contradicted, 2 unknown", and where there are any
// "; frames taken too late for their strobe or trigger pulses: 3; frames whose exposure was written late or
// never: 5".
std::string proof_of(const CaptureCounters& counters);

struct CapturedFrame {
  RawFrame raw;  // facts complete: exposure, source, verdict, slot, time of the centre, flags
  Judgement proof;
  int lost_before = 0;  // frames
  std::uint64_t cookie = 0;
  SlotShares shares;  // clipped and dark share of the picture
};

}  // namespace hdrcam
