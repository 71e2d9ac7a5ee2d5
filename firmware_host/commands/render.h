// The verb `render`; command.h says what a verb is.
#pragma once

#include "firmware_host/commands/command.h"

namespace hdrcam {

void add_render(CLI::App& app, Verb& chosen);

}  // namespace hdrcam
