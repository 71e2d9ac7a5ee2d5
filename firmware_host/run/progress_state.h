// How far a run is, and its text. Value type.
#pragma once

#include <optional>
#include <string>

namespace hdrcam {

struct ProgressState {
  int done = 0;
  std::optional<int> total;    // none while the length of the clip is unknown
  double ms_per_frame = 0;     // recent
  std::optional<double> loss;  // none without the fit

  // One more frame is done.
  void frame_done(double ms, std::optional<double> its_loss);
};

// The text, without a line end.
std::string progress_line(const ProgressState& state);

}  // namespace hdrcam
