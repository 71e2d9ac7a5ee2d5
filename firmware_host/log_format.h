// How lines for people and machines look on the standard error stream: plain text, or with --log-format json
// one JSON object per line, for a log collector:
//   {"time":"2026-11-22T06:00:00.123Z","level":"warning","message":"frame 12 is damaged"}
// The format belongs to the process. Thread-safe.
#pragma once

#include <string>
#include <string_view>

namespace hdrcam {

enum class LogFormat { Text, Json };
void set_log_format(LogFormat format);
LogFormat log_format();

// Status: the line that changes while a run goes on.
enum class LogLevel { Status, Note, Warning, Error };

// One object and a line end. Bytes that are no UTF-8 are replaced.
std::string json_log_line(LogLevel level, std::string_view message);

// Remarks as the program writes them, with "note: " or "warning: " in front and a line end each, as such
// lines.
std::string json_log_lines(std::string_view remarks);

}  // namespace hdrcam
