#include "firmware_host/run/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "firmware_host/run/frame_source.h"

namespace hdrcam {
namespace {

constexpr double kRecent = 0.1;  // weight of the newest frame in ms/frame

}  // namespace

void ProgressState::frame_done(double ms, std::optional<double> its_loss) {
  ms_per_frame = done == 0 ? ms : (1 - kRecent) * ms_per_frame + kRecent * ms;
  ++done;
  loss = its_loss;
}

std::string progress_line(const ProgressState& state) {
  std::string line = state.total ? fmt::format("frame {}/{}", state.done, *state.total)
                                 : fmt::format("frame {}", state.done);
  line += fmt::format("  {:.0f} ms/frame", state.ms_per_frame);
  if (state.loss) line += fmt::format("  loss {:.2g}", *state.loss);
  if (state.total) {
    const double left_s = std::max(0, *state.total - state.done) * state.ms_per_frame / 1000;
    const auto seconds = static_cast<long long>(std::ceil(left_s));
    line += fmt::format("  ETA {:02}:{:02}", seconds / 60, seconds % 60);
  }
  return line;
}

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
    if (now.done == shown.done && source.pace() == RunPace::Clip) continue;  // a camera's line keeps changing
    if (line.due()) line.show(source.status(shown = now));
  }
  if (const ProgressState last = progress.now(); last.done > shown.done) line.show(source.status(last));
}

}  // namespace hdrcam
