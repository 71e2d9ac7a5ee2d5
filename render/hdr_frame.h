// The output of the pipeline: one HDR frame with its facts, its uncertainty and the source of each pixel.
// Radiance is scene-linear and relative: 1 saturates the clip's reference exposure E_ref. Move-only value.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/image.h"
#include "online/priors/pose/frame_pose.h"

namespace hdrcam {

enum class Provenance : std::uint8_t {
  Own = 0,        // mostly this frame's own sample
  Carried = 1,    // mostly earlier frames, carried along the motion
  LookAhead = 2,  // mostly a later frame
  Field = 3,      // unseen: the field raised its lower bound, or gives all of it
  Bound = 4,      // clipped in all frames: a lower bound
};

inline constexpr std::size_t kProvenances = 5;

// The shares of the pixels [1, rows, cols] that have each provenance, by its number; they add up to 1, of an
// empty picture to 0.
std::array<float, kProvenances> provenance_shares(const Image<std::uint8_t>& provenance);

// A point on a static surface that the frame sees.
struct SurfacePoint {
  Eigen::Vector3d p_world;          // in the world and the unit of the frame's pose
  double u_px = 0, v_px = 0;        // where the frame sees it; pixel centres at +0.5
  std::array<float, 3> radiance{};  // [rgb] of that pixel
};

// What there is to say of a frame besides its pictures.
struct HdrFrameHead {
  FrameFacts facts;
  float exposure = 1;                          // E / E_ref of the frame it belongs to
  double reference_exposure = 1;               // E_ref, seconds x gains
  float white = 1;                             // radiance that saturates the shortest exposure of the cycle
  std::optional<ChannelGains> neutral_gains;   // to be applied, so that white is neutral; none where it is
  std::optional<ChannelGains> white_balance;   // applied to the radiance; none: the camera's own colours
  std::optional<FramePose> pose;               // none where it is not known
  LengthUnit length_unit = LengthUnit::Metre;  // of pose, depth and points
  std::optional<Intrinsics> lens;              // none where no single lens made the picture
  bool lens_is_assumed = false;                // the camera does not report it
  // The moment that a film's frame shows, from the recording's first frame; none of a recorded frame, which
  // shows its own.
  std::optional<double> recorded_s;
};

struct HdrFrame : HdrFrameHead {
  Image<float> radiance;  // [rgb, rows, cols], finite, >= 0
  // [1, rows, cols] standard deviation of ln(radiance + white / 5000) before shrinkage, 0..10
  Image<float> sigma;
  Image<std::uint8_t> provenance;  // [1, rows, cols] Provenance
  Image<float> depth;              // [1, rows, cols] camera z, in length_unit; empty without the field, or
                                   // while nothing of the scene has a known depth
  // [dx dy, rows, cols] pixels, each empty where it was not requested: to the previous frame (also empty for
  // the first), to the next one (without look-ahead and for the last), and the field's own motion both ways.
  Image<float> flow, flow_forward, field_flow, field_flow_forward;
  std::vector<SurfacePoint> points;  // empty where they were not requested

  HdrFrameHead& head() { return *this; }
  const HdrFrameHead& head() const { return *this; }
};

// The layers of float, radiance first.
inline constexpr std::array kFloatLayers{&HdrFrame::radiance,
                                         &HdrFrame::sigma,
                                         &HdrFrame::depth,
                                         &HdrFrame::flow,
                                         &HdrFrame::flow_forward,
                                         &HdrFrame::field_flow,
                                         &HdrFrame::field_flow_forward};

// Head, radiance, sigma and provenance; what depends on the field or on the neighbours stays. `to` keeps its
// memory.
inline void copy_picture(const HdrFrame& from, HdrFrame& to) {
  to.head() = from.head();
  to.radiance.copy_from(from.radiance);
  to.sigma.copy_from(from.sigma);
  to.provenance.copy_from(from.provenance);
}

}  // namespace hdrcam
