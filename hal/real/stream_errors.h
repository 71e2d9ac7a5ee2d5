// What a camera of this folder answers to a call at the wrong time, to a stream that no camera can have, and
// to a wait that ends without a frame. Each text names the camera, or what cannot be had. Reentrant.
#pragma once

#include <string>

#include "hal/camera.h"
#include "hal/core/instant.h"
#include "hal/core/result.h"

namespace hdrcam {

// Invalid: of configure(), start() and queue().
Error must_stop_to_configure(const std::string& id);
Error already_started(const std::string& id);
Error not_configured(const std::string& id);
Error not_started(const std::string& id);
// Invalid for other numbers of buffers than 1..most.
Result<void> check_buffers(int buffers, int most);
// Invalid for a picture without pixels.
Result<void> check_size(const StreamMode& wanted);

// Interrupted, Timeout and Io: of wait(). A stream fails where its device says so, and not why. The sentence
// of a time-out may go on: with the pulses that a trigger drove meanwhile.
Error stopped(const std::string& id);
Error no_frame_within(const std::string& id, Duration timeout);
Error stream_fails(const std::string& id, Duration timeout);

}  // namespace hdrcam
