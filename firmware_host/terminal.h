// What the program tells a person. Results go to the standard output, remarks and the status line to the
// standard error stream. Neither ever ends a run: a closed pipe, a lost session or a full disk behind one of
// them costs the words, not the recording. Lost results are remembered, so that the program can end with an
// error. Control characters in names are shown as numbers (printable.h). Thread-safe.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string_view>

namespace hdrcam {

// Files that the process opens must not get the numbers of the standard streams, or messages would be written
// into them: /dev/null replaces a closed one. In place of the standard output it takes nothing, so that
// results that nobody gets are an error. Call it before anything is opened.
void occupy_standard_streams();

void write_result(std::string_view text);
void write_remark(std::string_view text);

template <class... Args>
void say(fmt::format_string<Args...> form, Args&&... args) {
  write_result(fmt::format(form, std::forward<Args>(args)...));
}
template <class... Args>
void remark(fmt::format_string<Args...> form, Args&&... args) {
  write_remark(fmt::format(form, std::forward<Args>(args)...));
}

// A line on a terminal that is rewritten has no end (status_line.h): the next result or remark ends it first,
// and begins on a line of its own.
void leave_line_open(std::FILE* stream);
void end_open_line(std::FILE* stream);  // where nothing has ended it meanwhile

// errno of the first result that could not be written since the last call, 0 for none.
int lost_results();

// Columns of the terminal behind a stream; 0 where it is none or does not tell.
int columns_of(std::FILE* stream);

}  // namespace hdrcam
