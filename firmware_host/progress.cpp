#include "firmware_host/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr auto kTerminalInterval = std::chrono::milliseconds(50);
constexpr auto kLogInterval = std::chrono::seconds(1);
constexpr double kRecent = 0.1;  // weight of the newest frame in ms/frame

}  // namespace

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

Progress::Progress(std::FILE* stream, std::optional<int> total)
    : stream_(stream), terminal_(isatty(fileno(stream)) == 1) {
  state_.total = total;
}

Progress::~Progress() {
  if (terminal_ && shown_) fmt::print(stream_, "\n");
}

void Progress::frame_done(double ms, std::optional<double> loss, Clock::time_point now) {
  state_.ms_per_frame = state_.done == 0 ? ms : (1 - kRecent) * state_.ms_per_frame + kRecent * ms;
  ++state_.done;
  state_.loss = loss;
  const Clock::duration interval =
      terminal_ ? Clock::duration(kTerminalInterval) : Clock::duration(kLogInterval);
  const bool last = state_.total && state_.done == *state_.total;
  if (shown_ && now - *shown_ < interval && !last) return;
  shown_ = now;
  show();
}

void Progress::show() {
  const std::string line = progress_line(state_);
  if (!terminal_) {
    fmt::print(stream_, "{}\n", line);
  } else {
    // Blanks overwrite the rest of a longer line before.
    fmt::print(stream_, "\r{:<{}}", line, std::max(shown_width_, line.size()));
    shown_width_ = line.size();
  }
  std::fflush(stream_);
}

}  // namespace hdrcam
