// The complete estimate of one frame, delivered as soon as its look-ahead has arrived. Const, and valid only
// during the call that delivers it; only a snapshot of the field may be held longer. Thread-bound, but for
// that snapshot.
#pragma once

#include <array>
#include <optional>

#include "online/frame_budget.h"
#include "online/priors/depth/depth_prior.h"
#include "online/priors/pose/frame_pose.h"
#include "online/scene/scene_field.h"
#include "online/state/look_ahead.h"

namespace hdrcam {

struct FrameEstimate {
  const ExposedFrame& frame;
  const RadianceEstimate& state;              // with this frame, and the later ones that join it
  const Image<float>& own_share;              // of this frame in the state, before later ones joined it
  const Image<float>* later_share = nullptr;  // theirs in the result; null where none joins
  const FlowField* to_previous;               // null at the first frame
  // Vectors alone: only what joins later frames asks for their confidence. Null without look-ahead, and at
  // the last frame.
  const Image<float>* to_next = nullptr;
  FieldNow field;                      // fitted up to this frame, inclusive; empty without a field
  SceneView view;                      // the frame's own view, at full size, in the world of the field
  int world = 0;                       // counts them: views of two worlds do not belong together
  std::optional<FramePose> pose = {};  // the view's, as outputs state it; none where unknown
  const DepthMap* depth = nullptr;     // measured at this frame, in length_unit; null without a field
  float depth_unit = 1;                // of the field's depth (FieldPicture::depth), in length_unit
  LengthUnit length_unit = LengthUnit::Metre;  // of poses and depth
  bool lens_is_assumed = false;                // the camera does not report it
  const FitReport* fit;                        // the fit's work on this frame; null without a field
  NoiseOrigin noise_origin = NoiseOrigin::Unknown;
  FrameBudget budget;              // the cost allowed for this frame
  std::array<float, 3> darkest{};  // radiance up to which even the longest of the last exposures is black
  float white;                     // radiance that saturates the shortest of them
  float unseen_variance;           // from which on a pixel of the state counts as unseen
  double reference_exposure;       // E_ref, seconds x gains
  std::optional<ChannelGains> neutral_gains = {};  // of the radiance that leaves, so that white is neutral
};

}  // namespace hdrcam
