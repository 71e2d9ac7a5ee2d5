// The summary of a recording for `hdrcam info`: gathered in one pass over the facts, shown as a table or as
// JSON. The pixels are checked by their checksums but not decoded. Reentrant.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "hal/recording/exposure_cycle.h"
#include "hal/recording/recording.h"

namespace hdrcam {

struct RecordingSummary {
  CameraFacts camera;
  RecordingCodec codec = RecordingCodec::Huffyuv;
  std::uint64_t bytes = 0;    // of the file
  std::uint64_t frames = 0;   // whole ones
  std::uint64_t dropped = 0;  // missing sequence numbers
  std::uint64_t gaps = 0;     // runs of missing numbers
  std::uint64_t unproved = 0, damaged = 0, with_pose = 0;
  // Frames by the verdict on their exposure, and by the source of the exposure; zeros are left out.
  std::map<std::string, std::uint64_t> verdicts, sources;
  std::optional<BlackLevel> black_level;  // the first that a frame states
  Duration duration{0};                   // first to last centre of exposure, plus one frame
  // Products of time and gains, 0 where none is known.
  double shortest_exposure_s = 0, longest_exposure_s = 0;
  bool amplified = false;  // by a gain other than 1
  ExposureCycle cycle;
  LeftOut left_out;          // frames that are there, but damaged
  std::string behind;        // a sentence on another recording behind this one in the file; "": none
  std::optional<Error> end;  // why it ended early: Truncated; none where its end was reached
};

// Errors: those of open_recording; Interrupted once `stop` is set. A truncated or damaged recording is not an
// error.
Result<RecordingSummary> summarize(Storage& storage, const std::string& path, const std::atomic<bool>& stop);

std::string as_table(const RecordingSummary& summary, const std::string& path);
std::string as_json(const RecordingSummary& summary, const std::string& path);

}  // namespace hdrcam
