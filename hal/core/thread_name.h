// The name of a thread, as top, debuggers and traces show it. Reentrant.
#pragma once

#include <string>

namespace hdrcam {

// At most 15 bytes are kept.
void name_this_thread(const std::string& name);
std::string name_of_this_thread();

}  // namespace hdrcam
