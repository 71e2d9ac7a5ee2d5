// What is wrong with a command line that CLI11 refused, in our words. Reentrant.
#pragma once

#include "hal/core/result.h"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace hdrcam {

// The sentence for it, with the help to look at. app: as it parsed. An unknown flag comes first, because it
// usually causes the other errors (its value was taken for a positional, or the intended flag is missing).
Error not_understood(const CLI::App& app, const CLI::ParseError& refused);

}  // namespace hdrcam
