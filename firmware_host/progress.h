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
};

// The words, without a line end.
std::string progress_line(const ProgressState& state);

class Progress {
 public:
  using Clock = std::chrono::steady_clock;

  // stream: usually stderr; whether it is a terminal is found out here.
  Progress(std::FILE* stream, std::optional<int> total);
  ~Progress();  // ends the rewritten line, so that what is printed next starts on a line of its own
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // One more frame is done. It shows at most every 50 ms on a terminal, every second elsewhere, and always
  // for the last.
  void frame_done(double ms, std::optional<double> loss, Clock::time_point now = Clock::now());

 private:
  void show();

  std::FILE* const stream_;
  const bool terminal_;
  ProgressState state_;
  std::optional<Clock::time_point> shown_;
  std::size_t shown_width_ = 0;
};

}  // namespace hdrcam
