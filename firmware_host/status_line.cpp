#include "firmware_host/status_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "firmware_host/log_format.h"
#include "firmware_host/terminal.h"

namespace hdrcam {
namespace {

constexpr auto kTerminalInterval = std::chrono::milliseconds(50);
constexpr auto kLogInterval = std::chrono::seconds(1);

}  // namespace

StatusLine::StatusLine(std::FILE* stream)
    : stream_(stream), terminal_(log_format() == LogFormat::Text && isatty(fileno(stream)) == 1) {}

StatusLine::~StatusLine() { end_open_line(stream_); }

bool StatusLine::due(Clock::time_point now) const {
  return !shown_ || now - *shown_ >= (terminal_ ? Clock::duration(kTerminalInterval) : kLogInterval);
}

void StatusLine::show(const std::string& words, Clock::time_point now) {
  shown_ = now;
  if (log_format() == LogFormat::Json) {
    std::fputs(json_log_line(LogLevel::Status, words).c_str(), stream_);
  } else if (!terminal_) {
    std::fputs((words + "\n").c_str(), stream_);
  } else {
    // No wider than the terminal, where a line that wraps would stay; blanks overwrite the rest of a longer
    // one, which the terminal has cut where it became narrower.
    const auto columns = static_cast<std::size_t>(std::max(0, columns_of(stream_)));
    const std::size_t most = columns > 1 ? columns - 1 : std::string::npos;
    const std::string shown = words.substr(0, most);
    const std::size_t width = std::min(std::max(shown_width_, shown.size()), most);
    std::fputs(fmt::format("\r{:<{}}", shown, width).c_str(), stream_);
    shown_width_ = shown.size();
    leave_line_open(stream_);
  }
  std::fflush(stream_);
}

}  // namespace hdrcam
