// The pace of a run: of its source, and so of its sinks. Plain value.
#pragma once

namespace hdrcam {

// A clip waits for every sink; a camera does not wait, so sinks that may leave out frames do, and their
// threads have a lower priority than capture.
enum class RunPace { Clip, Camera };

}  // namespace hdrcam
