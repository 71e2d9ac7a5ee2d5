// The standard streams of the process. Thread-bound: before any thread starts.
#pragma once

namespace hdrcam {

// Files that the process opens must not get the numbers of the standard streams, or messages would be written
// into them: /dev/null replaces a closed one. Call it before anything is opened.
void occupy_standard_streams();

}  // namespace hdrcam
