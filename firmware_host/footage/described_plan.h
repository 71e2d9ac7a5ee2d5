// A plan of footage in words. Reentrant.
#pragma once

#include <string>

#include "firmware_host/footage/footage_plan.h"

namespace hdrcam {

// A sentence without a full stop: the file, how much it lacks, and what becomes of the rest.
std::string describe(const FootageLosses& losses);

// "2 frames are missing, before frame 3", as the exposures show, and where they are many that the named cycle
// may be wrong; "" where none is.
std::string describe_missing(const FootagePlan& plan);

// "the pictures are turned by 90 degrees, as the files state"; "" where all stay as they are stored.
std::string describe_turns(const FootagePlan& plan);

// Where more than an eighth of the frames, three at least, look as the one before them: that a program may
// have copied them; else "".
std::string describe_copies(const FootagePlan& plan);

// Where EXIF shows a pause between stills: that they may be of several scenes, or in other light, which would
// explain exposures that pictures contradict; else "".
std::string describe_pause(const FootagePlan& plan);

// For people: what the footage is, its cycle, what is missing, and the first frames.
std::string described(const FootagePlan& plan);

}  // namespace hdrcam
