// Learns the response of a stream: from its first frames, and again while it goes on where these showed
// little of it (a covered lens, a dark room, a white wall). Now and then some frames in a row are added to
// what is known already, and the fit is done again on a thread of its own. Its answer is taken only where it
// is far more certain: the state must begin anew with it. When that is depends on the frames alone, not on
// the machine. Thread-bound.
#pragma once

#include <future>
#include <optional>
#include <span>
#include <vector>

#include "capture/compact_frame.h"
#include "online/response/response_estimator.h"

namespace hdrcam {

class ResponseLearner {
 public:
  struct Options {
    ResponseModel model = ResponseModel::Curve;
    int frames = 6;       // in a row that are looked at together
    float code_step = 1;  // of the quantiser, in codes of 255
    int bits = 8;         // of the camera's codes
  };
  explicit ResponseLearner(Options options) : options_(options) {}

  // Of the first frames, unpacked without a black level. noise: the uncertainty of the codes.
  ResponseEstimate first(std::span<const CompactFrame> frames, const NoiseModel& noise);
  // Takes the next frame, unpacked without a black level. What the response is from this frame on, where that
  // is far more certain than before; nearly always nothing. May wait for the fit of frames long ago.
  std::optional<ResponseEstimate> next(const ExposedFrame& frame, const NoiseModel& noise);

  // False while no two exposures showed one scene, and the mean of real cameras stands in.
  bool measured() const { return measured_; }

 private:
  void look(std::span<const CompactFrame> frames, SceneCuts cuts);

  const Options options_;
  ResponseEstimator estimator_;  // of the fit alone, while it runs
  bool measured_ = false;
  double uncertainty_ = 0;  // of the response in use
  long frames_ = 0;         // so far
  long look_at_ = 0;        // the frame with which the next look begins
  std::vector<CompactFrame> window_;
  std::future<ResponseEstimate> fit_;  // last: it ends before what it reads
};

}  // namespace hdrcam
