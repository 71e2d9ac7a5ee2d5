// Who is told how long a stage of a frame took.
#pragma once

#include <functional>

namespace hdrcam {

// stage: of static storage. Called on the thread that worked, once it has.
using StageTiming = std::function<void(const char* stage, double ms)>;

}  // namespace hdrcam
