#include "firmware_host/run/progress.h"

#include <chrono>

namespace hdrcam {

void Progress::frame_done(double ms, std::optional<double> loss, Clock::time_point now) {
  state_.frame_done(ms, loss);
  const bool last = state_.total && state_.done == *state_.total;
  if (last || line_.due(now)) line_.show(progress_line(state_), now);
}

void show_progress(std::FILE* stream, const FrameSource& source, const SharedProgress& progress,
                   const std::future<Result<void>>& work) {
  constexpr auto kLook = std::chrono::milliseconds(20);
  StatusLine line(stream);
  ProgressState shown;
  while (work.wait_for(kLook) != std::future_status::ready) {
    const ProgressState now = progress.now();
    const bool goes_on = now.done > shown.done || now.read > shown.read;
    if (!goes_on && source.pace() == RunPace::Clip) continue;  // a camera's line keeps changing
    if (line.due()) line.show(source.status(shown = now));
  }
  if (const ProgressState last = progress.now(); last.done > shown.done) line.show(source.status(last));
}

}  // namespace hdrcam
