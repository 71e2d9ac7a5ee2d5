// A camera whose exposures follow what the fit asks for, and the score of its HDR frames against the truth of
// the simulated scene. Which frames there are depends on the cycle, so no clip can be filmed beforehand: the
// simulated camera runs in virtual time, each frame goes through the whole run (run/run.h) before the next
// one is captured, and the truth is rendered at the middle of each exposure. The same loop gives the same
// frames on every machine. Thread-bound; everything is in memory.
#pragma once

#include <string>
#include <vector>

#include "capture/exposure.h"
#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/run_record.h"

namespace hdrcam::test {

struct LoopRun {
  std::string scene;                 // "fast?size=160x120"
  Settings::Schedule schedule = {};  // the cycle that it begins with, and what it follows
  int frames = 60;
  int first_scored = 30;  // from then on the frames count: the cycle has found its place
};

struct LoopOutcome {
  double mean_db = 0, worst_db = 0;  // PSNR-mu of the frames scored
  int wrong_labels = 0;              // frames that were trusted with an exposure that they did not have
  int changes = 0;                   // of the cycle
  std::vector<Exposure> last_cycle;
  RunRecord record;
};

// The white of the scores is that of the cycle that the loop begins with, so that two loops over one scene
// compare.
LoopOutcome closed_loop(const LoopRun& wanted);

}  // namespace hdrcam::test
