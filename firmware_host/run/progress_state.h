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
  int read = 0;                // frames of the recording before the first one of its film

  // One more frame is done.
  void frame_done(double ms, std::optional<double> its_loss);
  // One more frame of the recording is fitted, of which a film is made.
  void frame_read(double ms);
};

// The text, without a line end.
std::string progress_line(const ProgressState& state);

}  // namespace hdrcam
