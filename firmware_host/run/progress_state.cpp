#include "firmware_host/run/progress_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr double kRecent = 0.1;  // weight of the newest frame in ms/frame

}  // namespace

void ProgressState::frame_done(double ms, std::optional<double> its_loss) {
  ms_per_frame = done == 0 ? ms : (1 - kRecent) * ms_per_frame + kRecent * ms;
  ++done;
  loss = its_loss;
}

void ProgressState::frame_read(double ms) {
  if (done > 0) return;
  ms_per_frame = read == 0 ? ms : (1 - kRecent) * ms_per_frame + kRecent * ms;
  ++read;
}

std::string progress_line(const ProgressState& state) {
  if (state.done == 0 && state.read > 0)
    return fmt::format("recorded frame {}  {:.0f} ms/frame", state.read, state.ms_per_frame);
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

}  // namespace hdrcam
