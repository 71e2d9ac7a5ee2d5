// The requirements of every SyncLine and every TriggerLine: libgpiod's, the simulated and the faulty one. See
// camera_contract.h.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/sync_line.h"
#include "hal/trigger_line.h"

namespace hdrcam {

struct InputLineUnderTest {
  std::string name;
  std::function<Result<std::unique_ptr<SyncLine>>()> open;  // an input
  std::function<void(bool active)> drive;  // sets the level that the line sees; each change is an edge
  Duration patience = std::chrono::seconds(2);
};
struct OutputLineUnderTest {
  std::string name;
  std::function<Result<std::unique_ptr<TriggerLine>>()> open;
  std::function<bool()> level;  // of the line now, seen from its other end
};

void keeps_input_line_contract(const InputLineUnderTest& line);
void keeps_output_line_contract(const OutputLineUnderTest& line);

}  // namespace hdrcam
