// The window: the last few frames, each with its codes, its exposure, its pose and its base. The base holds
// the state of a frame as planes: log radiance, the share that the networks may change (the gate), and the
// flow to both neighbours. The networks of the field add a residual to the base, so that a field of zero
// steps renders the state's picture. A pixel of the window may be a block of the stream's pixels
// (WindowFrustum::step_px): the window then keeps the blocks' means. Frames are ordered by arrival;
// neighbours are neighbours in that order. Readers (snapshots) hold frames; a held frame is never written:
// the writer continues in a copy. The constructor allocates all buffers except those copies. Writing is
// thread-bound, reading is reentrant.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/flow_field.h"
#include "online/scene/hash_grid/field/view_geometry.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

// One frame with its state. Pictures are [rgb, rows, cols] of the stream, borrowed for the call; values that
// are not finite are treated as unseen. Flow may be empty or null at the first frame and after a cut.
struct FieldObservation {
  int index = 0;                             // increasing; gaps are dropped frames
  double time_s = 0;                         // centre of the exposure
  float exposure = 1;                        // E / E_ref, known, never fitted
  float blur_fraction = 0;                   // exposure time over frame interval
  const Image<float>* codes = nullptr;       // 0..255
  const Image<float>* radiance = nullptr;    // state
  const Image<float>* variance = nullptr;    // of radiance
  float unseen_variance = kUnseenVariance;   // from which on a pixel counts as unseen
  const FlowField* to_previous = nullptr;    // this frame -> previous
  const FlowField* from_previous = nullptr;  // previous frame -> this one
  // [1, rows, cols] of the window: near / z, NaN where unknown; null: none.
  const Image<float>* inverse_depth = nullptr;
  RigidTransform T_world_camera;  // identity where the camera is fixed or unknown
};

// The base of one pixel, interleaved because the field reads all of it at a fractional position.
constexpr int kBaseChannels = 16;  // a cache line; three are not used
using BasePixel = std::array<float, kBaseChannels>;
enum BaseChannel : int {
  kBaseLogRadiance = 0,  // rgb
  kBaseGate = 3,         // rgb 0..1: V / (V + trusted_sigma^2), V the variance of log radiance
  kBaseFlow = 6,         // forward u v, backward u v: displacement in window space in pixels of the anchor
  kBaseConfidence = 10,  // forward, backward 0..1
  kBaseSurface = 12,     // inverse depth of the pixel's surface, as far as it is known
};

// Of the three channels.
inline float mean_gate(const float* base) {
  return (base[kBaseGate] + base[kBaseGate + 1] + base[kBaseGate + 2]) / 3;
}

struct WindowFrame {
  int index = -1;
  int slot = 0;  // of the dynamic hash grid
  double time_s = 0;
  float exposure = 1, blur_fraction = 0;
  RigidTransform T_world_camera, T_anchor_camera;
  Image<float> values;    // [rgb, rows, cols] codes / 255; kNoValue where the code is not a measurement
  Image<BasePixel> base;  // [1, rows, cols]
  // [1, rows / kGuideStep, cols / kGuideStep] inverse depth of the surfaces of the last field.
  Image<float> guide;
  Image<std::uint8_t> prior_guides;   // as guide: 1 where the depth prior gives the tile's
  Image<float> depth_prior;           // [1, rows, cols], empty without one
  bool has_flow[2] = {false, false};  // by Neighbour
  float dynamic_share = 0;            // of the pixels whose flow prior exceeds a quarter of a pixel
  int holders = 0;                    // snapshots that hold it; counted by the thread that writes the window

  bool knows_flow(Neighbour which) const { return has_flow[static_cast<int>(which)]; }
  void copy_from(const WindowFrame& other);  // everything except the holders
};

constexpr float kNoValue = -1;
constexpr int kGuideStep = 8;
// The longest displacement of a base, up and down, in pixels of the anchor: that of what lies beside or
// behind the anchor's camera, as it does where a view turns away or jumps, grows each time that the anchor
// moves.
constexpr float kMostShift = 1e15f;

struct WindowOptions {
  // At most what the fit's shaders have room for: a uniform block of 84 vec4, six a view
  // (fit/vulkan/gpu_rays.cpp).
  static constexpr int kFewestFrames = 2, kMostFrames = 14;
  int frames = 6;  // kFewestFrames..kMostFrames; longer windows cost memory and, in dynamic scenes, quality
  // Of log radiance, 0.01..1: sigma at which networks and state have equal weight.
  float trusted_sigma = 0.1f;
  float default_inverse_depth = 0.3f;  // 0..1, where nothing is known about depth
};

// The frames of a window as a reader sees them, oldest first.
class WindowFrames {
 public:
  explicit WindowFrames(const WindowFrustum& frustum) : frustum_(frustum) {}
  // Of given frames, which outlive it.
  WindowFrames(const WindowFrustum& frustum, const RigidTransform& T_world_anchor,
               std::vector<WindowFrame*> frames)
      : frustum_(frustum), T_world_anchor_(T_world_anchor), order_(std::move(frames)) {}

  int size() const { return static_cast<int>(order_.size()); }
  const WindowFrame& frame(int i) const { return *order_[static_cast<std::size_t>(i)]; }
  const WindowFrame& newest() const { return frame(size() - 1); }
  int nearest(double time_s) const;  // position of the frame nearest in time
  const WindowFrustum& frustum() const { return frustum_; }
  const RigidTransform& T_world_anchor() const { return T_world_anchor_; }
  RigidTransform T_anchor_camera(const RigidTransform& T_world_camera) const;
  // whether poses differ by a translation that shifts the near plane by half a pixel or more
  bool has_parallax() const;
  bool has_motion() const;  // whether more than a thousandth of the pixels of some frame move

 protected:
  friend class Window;
  WindowFrustum frustum_;
  RigidTransform T_world_anchor_;
  std::vector<WindowFrame*> order_;
};

class Window : public WindowFrames {
 public:
  Window(const WindowFrustum& frustum, const WindowOptions& options);

  // Adds the frame and drops the oldest. Invalid for a picture of another size or a missing one; BadExposure
  // for an exposure that is not a positive number.
  Result<void> advance(const FieldObservation& seen, WorkerPool& pool);
  // Makes the newest frame the anchor and recomputes the bases. Returns T_new_old of the anchors.
  RigidTransform move_anchor();
  void clear() { order_.clear(); }
  // The frame to write to: the frame itself, or a copy that replaces it where a snapshot holds it.
  WindowFrame& writable(int i);

  // Holds the current frames for a reader; release() gives them back. Only the thread that writes the window
  // may call them, while no thread reads `held`.
  void hold(WindowFrames& held);
  static void release(WindowFrames& held);

  int slots() const { return options_.frames + 1; }  // one more than frames, to avoid collisions
  bool anchor_is_stale() const;  // a corner of the newest view leaves the window at mid depth

 private:
  WindowFrame& spare();
  std::unique_ptr<WindowFrame> make_frame() const;
  void take_base(const FieldObservation& seen, WindowFrame& frame, WorkerPool& pool) const;
  void take_flow(const FlowField& flow, WindowFrame& from, const WindowFrame& to, Neighbour which,
                 WorkerPool& pool) const;

  WindowOptions options_;
  // One more than the window's frames; more while snapshots hold some.
  std::vector<std::unique_ptr<WindowFrame>> storage_;
  long arrived_ = 0;
};

// The base at a fractional pixel (clamped to the picture), bilinear: value[kBaseChannels], and its slopes
// along x and y unless they are null. Pixel centres at +0.5.
template <class T>
void fetch_base(const Image<BasePixel>& base, const T pixel[2], T* value, T* d_x, T* d_y) {
  T x = pixel[0] - T(0.5), y = pixel[1] - T(0.5);
  const T last_x = T(base.cols() - 1), last_y = T(base.rows() - 1);
  const bool inside_x = x > 0 && x < last_x;
  const bool inside_y = y > 0 && y < last_y;
  // as in_picture() of vulkan/camera.glsl: what is not a number is in the picture, too
  const auto within = [](T at, T last) {
    const T near = at < last ? at : last;
    return near > 0 ? near : T(0);
  };
  x = within(x, last_x), y = within(y, last_y);
  const int i = std::min(static_cast<int>(x), std::max(base.cols() - 2, 0));
  const int j = std::min(static_cast<int>(y), std::max(base.rows() - 2, 0));
  const int right = base.cols() > 1 ? 1 : 0, below = base.rows() > 1 ? 1 : 0;
  const BasePixel &a = base.at(0, j, i), &b = base.at(0, j, i + right);
  const BasePixel &c = base.at(0, j + below, i), &d = base.at(0, j + below, i + right);
  const T fx = x - T(i), fy = y - T(j);
  const T wa = (1 - fx) * (1 - fy), wb = fx * (1 - fy), wc = (1 - fx) * fy, wd = fx * fy;
  for (std::size_t k = 0; k < a.size(); ++k)
    value[k] = wa * T(a[k]) + wb * T(b[k]) + wc * T(c[k]) + wd * T(d[k]);
  if (d_x == nullptr) return;
  for (std::size_t k = 0; k < a.size(); ++k) {
    d_x[k] = inside_x ? (1 - fy) * (T(b[k]) - T(a[k])) + fy * (T(d[k]) - T(c[k])) : T(0);
    d_y[k] = inside_y ? (1 - fx) * (T(c[k]) - T(a[k])) + fx * (T(d[k]) - T(b[k])) : T(0);
  }
}
template <class T>
void fetch_base(const Image<BasePixel>& base, const T pixel[2], T* value) {
  fetch_base<T>(base, pixel, value, nullptr, nullptr);
}

}  // namespace hdrcam
