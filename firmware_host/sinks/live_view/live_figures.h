// What a live view says in figures: JSON for its page, Prometheus' text format for monitoring
// (docs/live-view.md lists both). Reentrant.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/sinks/live_view/emission_tally.h"
#include "firmware_host/sinks/live_view/newest_frame.h"

namespace hdrcam {

// Where the run is, as a page or a monitor sees it.
struct LiveFigures {
  const ShownFrame* frame = nullptr;  // the newest; null before the first
  EmissionFigures emission;
  std::vector<NamedValue> counters = {};  // of the camera (RunControl), empty in a replay
  std::string recording = {};             // the file that is open
};

// Of the frame's histogram: counts of pixels by log2 luminance, kLeastStop to kMostStop; the outer ones hold
// what is beyond.
constexpr int kHistogramBins = 40;

std::string status_json(const LiveFigures& figures);
std::string prometheus_text(const LiveFigures& figures);

// A pixel of the frame as /frame.exr has it, and its uncertainty. x, y: inside the picture.
std::string pixel_json(const ShownFrame& frame, int x, int y);

}  // namespace hdrcam
