// One changing line of text on a stream: rewritten on a terminal, printed line by line elsewhere (a log file,
// a pipe), at most one per second. What is written meanwhile stands on lines of its own (terminal.h).
// Thread-bound.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>

namespace hdrcam {

class StatusLine {
 public:
  using Clock = std::chrono::steady_clock;

  // stream: usually stderr; the constructor checks whether it is a terminal.
  explicit StatusLine(std::FILE* stream);
  ~StatusLine();  // ends the rewritten line
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  // Whether an update is due: every 50 ms on a terminal, every second elsewhere.
  bool due(Clock::time_point now = Clock::now()) const;
  void show(const std::string& words, Clock::time_point now = Clock::now());

 private:
  std::FILE* const stream_;
  const bool terminal_;
  std::optional<Clock::time_point> shown_;
  std::size_t shown_width_ = 0;
};

}  // namespace hdrcam
