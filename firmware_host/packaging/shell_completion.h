// Completion of the command line in a shell: verbs, flags, and the words of flags that take one of a few; a
// text completes as a file, a number not at all. Reentrant.
#pragma once

#include <string>

#include "firmware_host/packaging/command_table.h"

namespace hdrcam {

std::string bash_completion(const CommandTable& table);
std::string zsh_completion(const CommandTable& table);
std::string fish_completion(const CommandTable& table);

}  // namespace hdrcam
