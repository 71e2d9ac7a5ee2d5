// What the outputs of a run need of the method besides the HDR frames, how these are written, and where
// results are told beside them. Reentrant.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "firmware_host/run_pace.h"
#include "firmware_host/settings/settings.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "render/exr.h"

namespace hdrcam {

struct OutputNeeds {
  bool depth = false;
  bool flow_backward = false;  // to the previous frame
  bool flow_forward = false;   // to the next frame: needs look-ahead
  bool field_flow = false;     // to both neighbours
  bool poses = false;          // which are tracked where the field is
  bool points = false;
  bool scene = false;  // of which the field is a part

  bool shows_field() const { return depth || field_flow; }
};
OutputNeeds needs_of(const Settings::Output& output);

// What to say of motion that is asked for, and that the run does not wait long enough for to know; "" for
// nothing.
std::string note_on_motion(const Settings& settings, const CameraFacts& camera);

// The first output with motion, as it was asked for: "--flow-forward" or "--layers flow"; "" for none.
std::string motion_output(const Settings::Output& output);

// Whether the field is seen in the scene that is saved: a recording waits for it as a film would have it; of
// a camera it is what the frames leave time for.
bool sees_field_in_scene(const Settings::Output& output, RunPace pace);

ExrCompression compression_of(const Settings::Output& output, RunPace pace);
// The gains of all outputs; none: colours as the sensor gives them. Errors: those of white_balance_gains.
Result<std::optional<ChannelGains>> white_balance_of(const Settings::Output& output,
                                                     const CameraFacts& camera);

// Writes a result to the standard output; to the standard error stream where the frames take that.
void write_result_beside_frames(const Settings::Output& output, std::string_view text);

// Invalid where the settings switch off what an output needs, where there are no pictures for its poses, and
// for an address of the live page that is none or a token that is too short.
Result<void> check_needs(const Settings& settings);

// The flag of an output that needs poses, where there is one.
const char* flag_of_poses(const Settings::Output& output);
// Whether the run tracks poses, which the field is for.
bool tracks_poses(const Settings& settings);
// Where no poses are given. Invalid where outputs need them and none is tracked; cause: why none is given,
// for the message: "a camera states none".
Result<void> check_tracked_poses(const Settings& settings, std::string_view cause);

}  // namespace hdrcam
