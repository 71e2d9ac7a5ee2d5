// The requirements of every Camera, for any implementation: a sensor, a simulation, a recording, or a wrapper
// that injects faults. One list; a test of an implementation names the camera and runs the list over it:
//
//   TEST_CASE("the simulated camera keeps the camera contract") {
//     keeps_camera_contract({.name = "simulated", .open = [] { return open_simulated_camera(...); }, ...});
//   }
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/camera.h"

namespace hdrcam {

struct CameraUnderTest {
  std::string name;
  std::function<Result<std::unique_ptr<Camera>>()> open;  // a new one each time, not configured
  StreamMode mode;                                        // one that it has
  int buffers = 4;                                        // for configure(), at least 3
  ExposureRequest short_exposure{.exposure = std::chrono::milliseconds(1)};
  ExposureRequest long_exposure{.exposure = std::chrono::milliseconds(8)};
  Duration patience = std::chrono::seconds(2);  // time limit for a queued frame
  int frames = 60;                              // of the longer runs; a replayed camera must hold as many
  bool drops_frames = false;                    // sequence numbers may have gaps (they still increase)
  bool repeats_sequence = false;     // the driver counts with a timer that may be late (the kernel's vivid)
  double allocations_per_frame = 0;  // at most, inside a library; 0 for all code of this project
};

// Runs the whole list, each entry as a section of the running test case.
void keeps_camera_contract(const CameraUnderTest& camera);

}  // namespace hdrcam
