// The requirements of every SyncLine: libgpiod's, the simulated, the replayed and the faulty one. See
// camera_contract.h.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/sync_line.h"

namespace hdrcam {

struct InputLineUnderTest {
  std::string name;
  std::function<Result<std::unique_ptr<SyncLine>>()> open;  // an input
  std::function<void(bool active)> drive;  // sets the level that the line sees; each change is an edge
  Duration patience = std::chrono::seconds(2);
};
struct OutputLineUnderTest {
  std::string name;
  std::function<Result<std::unique_ptr<SyncLine>>()> open;  // an output
  std::function<bool()> level;                              // what the line drives now
  Duration overshoot = std::chrono::milliseconds(20);       // by which a pulse may be longer than requested
};

void keeps_input_line_contract(const InputLineUnderTest& line);
void keeps_output_line_contract(const OutputLineUnderTest& line);

}  // namespace hdrcam
