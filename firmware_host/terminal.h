// The standard streams of the process. Thread-bound: before any thread starts.
#pragma once

namespace hdrcam {

// Files that the process opens must not get the numbers of the standard streams, or words for a person would
// land in them: where one is closed, /dev/null takes its place. Call before anything is opened.
void occupy_standard_streams();

}  // namespace hdrcam
