// How far a run is, for the person at the terminal. On a terminal one line is rewritten:
//   frame 12/48  61 ms/frame  loss 0.021  ETA 00:03
// elsewhere (a log file, a pipe) the same words become plain lines, one a second at most. Thread-bound.
#pragma once

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace hdrcam {

struct ProgressState {
  int done = 0;
  std::optional<int> total;    // unknown while the end of the clip is
  double ms_per_frame = 0;     // recent
  std::optional<double> loss;  // none without the fit

  // One more frame is done.
  void frame_done(double ms, std::optional<double> its_loss);
};

// The words, without a line end.
std::string progress_line(const ProgressState& state);

// One line of words that change: rewritten on a terminal, a line each elsewhere.
class StatusLine {
 public:
  using Clock = std::chrono::steady_clock;

  // stream: usually stderr; whether it is a terminal is found out here.
  explicit StatusLine(std::FILE* stream);
  ~StatusLine();  // ends the rewritten line, so that what is printed next starts on a line of its own
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  // Whether it is time to show again: every 50 ms on a terminal, every second elsewhere.
  bool due(Clock::time_point now = Clock::now()) const;
  void show(const std::string& words, Clock::time_point now = Clock::now());

 private:
  std::FILE* const stream_;
  const bool terminal_;
  std::optional<Clock::time_point> shown_;
  std::size_t shown_width_ = 0;
};

class Progress {
 public:
  using Clock = StatusLine::Clock;

  Progress(std::FILE* stream, std::optional<int> total) : line_(stream) { state_.total = total; }

  // One more frame is done. It shows when the line is due, and always for the last.
  void frame_done(double ms, std::optional<double> loss, Clock::time_point now = Clock::now());

 private:
  StatusLine line_;
  ProgressState state_;
};

}  // namespace hdrcam
