// Learns the response of a stream from its first frames. While these showed little of it (a covered lens, a
// dark room, a white wall), it goes on: at once and then after pauses of half of the stream so far, 6 to 300
// frames, a window of 6 frames in a row is added to what is known, and the fit is done again in the
// background, on a thread of its own, or where the system refuses one when it is taken. The answer is taken
// 18 frames after the window began, however early the thread is ready, so that results do not depend on the
// machine; and only where its uncertainty is at most half of that in use, because the state must begin anew
// with it. Thread-bound.
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
    int frames = 6;                      // in a row that are looked at together
    float code_step = 1;                 // of the quantiser, in codes of 255
    int bits = 8;                        // of the camera's codes
    bool light_may_change = true;        // from frame to frame (first_light.h)
    std::optional<Response> known = {};  // then only exposures and noise are learned
  };
  explicit ResponseLearner(Options options) : options_(options) {}
  ResponseLearner(const ResponseLearner&) = delete;  // its fit reads it from another thread
  ResponseLearner& operator=(const ResponseLearner&) = delete;

  // Looks at one of the first frames as it comes, its black level in it unless the response is known; before:
  // the one before it, or null. So there is less to do when there are enough of them.
  void see_first(const ExposedFrame& frame, const CompactFrame* before);
  // What these first frames, all of which have been seen, tell. noise: the uncertainty of the codes.
  ResponseEstimate first(std::span<const CompactFrame> frames, const NoiseModel& noise, WorkerPool& pool);
  // Takes the next frame, its black level in it. What the response is from this frame on, where that is far
  // more certain than before; nearly always nothing. May wait for the fit of frames long ago.
  std::optional<ResponseEstimate> next(const ExposedFrame& frame, const NoiseModel& noise);

  // False while neither two exposures of one scene nor the sensor's own noise told of the curve, and the mean
  // of real cameras stands in.
  bool measured() const { return measured_; }
  double uncertainty() const { return uncertainty_; }  // of the response in use: one sigma of ln x

 private:
  void look(std::span<const CompactFrame> frames, std::span<const float> light, SceneCuts cuts);
  std::vector<float> light_of(std::span<const CompactFrame> frames) const;
  ResponseEstimate of_stated(ResponseEstimate estimate, std::span<const CompactFrame> frames,
                             std::span<const float> light) const;
  bool is_measured(const ResponseEstimate& estimate) const;

  const Options options_;
  ResponseEstimator estimator_;  // of the fit alone, while it runs
  bool measured_ = false;
  bool unsteady_ = false;   // the light of some frames that were looked at
  double uncertainty_ = 0;  // of the response in use
  long frames_ = 0;         // so far
  long look_at_ = 0;        // the frame with which the next look begins
  std::vector<CompactFrame> window_;
  std::future<ResponseEstimate> fit_;  // last: it ends before what it reads
};

}  // namespace hdrcam
