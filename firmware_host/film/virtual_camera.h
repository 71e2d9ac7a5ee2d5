// A virtual camera in the scene of a recording: it takes the run's HDR frames as they are emitted and films
// them anew as planned, from its own place, at its own moments, with its own shutter and size
// (render/views/). It keeps the frames that its next moments lie between, and renders each film frame as soon
// as they are there. Or it takes a scene that was saved, all at once (scene_snapshot.h). Thread-bound.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>

#include "firmware_host/film/film_plan.h"
#include "firmware_host/film/scene_snapshot.h"
#include "firmware_host/film/steady_path.h"
#include "firmware_host/sinks/run_record.h"
#include "online/frame_estimate.h"
#include "online/response/response.h"
#include "render/views/keyframe_maker.h"
#include "render/views/view_renderer.h"

namespace hdrcam {

class VirtualCamera {
 public:
  // A film frame with the newest input at that time. Valid during the call.
  using Show = std::function<Result<void>(HdrFrame&, const ExposedFrame&, const FrameRecord&)>;

  // white_balance: of its frames, before a response makes codes of their light. The pool outlives the camera.
  VirtualCamera(const FilmPlan& plan, const std::optional<ChannelGains>& white_balance, WorkerPool& pool);

  // response: with which the frame was estimated. Errors: those of show.
  Result<void> take(const HdrFrame& frame, const FrameEstimate& estimate, const Response& response,
                    const Show& show);
  // The frames and the field of a saved scene, instead of a run's. Its field outlives the camera.
  void take(SceneSnapshot& scene);
  // Films the remaining moments from the last frames. Errors: those of show.
  Result<void> finish(const Show& show);

  // Whether all frames of the film were shown.
  bool done() const { return shown_ == plan_.frames; }
  int shown() const { return shown_; }
  // All pixels shown, and those of them that came from the field.
  std::uint64_t pixels() const { return pixels_; }
  std::uint64_t filled_pixels() const { return filled_pixels_; }

 private:
  struct ExposureInterval {  // of scene time; empty where it stands still, or the frame shows one instant
    double from_s, to_s;
  };
  enum class Eye { Left = -1, Middle = 0, Right = 1 };  // Middle: of a film without stereo
  ExposureInterval exposure_of(int frame) const;
  void add_to_path(const Keyframe& key);
  bool ready(int frame) const;
  Result<void> film(const Show& show);
  KeyframeInterval interval_at(double time_s) const;
  RigidTransform T_world_view(const KeyframeInterval& interval, double playback_s, Eye eye) const;
  double speed_px_s(const Keyframe& before, const Keyframe& after) const;
  double recorded_way_px(const ExposureInterval& exposure) const;
  double path_way_px(int frame) const;
  int instants(int frame) const;
  void expose(int frame, Eye eye, HdrFrame& out);
  void join_eyes();
  void label(int frame);
  void state_camera(const KeyframeInterval& interval, double playback_s);
  Intrinsics filming_lens(const Keyframe& key) const;
  void drop_old();
  void keep_response(double from_s, const Response& response);
  const Response& response_of(const Keyframe& key) const;

  struct ResponseInUse {
    double from_s;  // the time of its first keyframe
    Response response;
  };
  const FilmPlan plan_;
  const std::optional<ChannelGains> white_balance_;
  KeyframeMaker maker_;
  ViewRenderer renderer_;
  SteadyPath steady_;
  std::deque<std::unique_ptr<Keyframe>> keys_;
  std::vector<std::unique_ptr<Keyframe>> spare_;
  SnapshotHold field_;                   // the newest, of the newest keyframe's world
  std::deque<ResponseInUse> responses_;  // of the frames in keys_; nearly always one
  ExposedFrame input_;
  HdrFrame frame_, instant_, left_;
  Image<float> sum_;
  int shown_ = 0;
  std::uint64_t pixels_ = 0, filled_pixels_ = 0;
};

}  // namespace hdrcam
