#include "online/scene/hash_grid/field/window.h"

#include <atomic>
#include <cmath>

#include "capture/clip_policy.h"
#include "capture/exposed_frame.h"
#include "online/scene/hash_grid/field/surface_guide.h"
#include "online/scene/hash_grid/field/window_kernels.h"

namespace hdrcam {
namespace {

constexpr float kStatic_px = 0.25f;    // of the stream
constexpr double kLeastStep_s = 1e-3;  // after a frame that is no earlier than this one: times increase
constexpr float kClippedCode = clip_policy::kLossOfOne.brightest * kMaxCode;
constexpr int kRun = kMostBlocks;  // pixels of a row that a kernel takes at once

// Calls body(y, x, count) for all runs of all rows.
template <class Body>
void for_runs(WorkerPool& pool, int rows, int cols, Body&& body) {
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; x += kRun) body(y, x, std::min(kRun, cols - x));
  });
}

// Whether it is a picture of the stream that the window's pixels cover.
bool is_of_stream(const Image<float>* image, int channels, const WindowFrustum& window) {
  const int step = window.step_px;
  return image != nullptr && image->channels() == channels &&
         (image->rows() + step - 1) / step == window.rows && (image->cols() + step - 1) / step == window.cols;
}

bool usable(const FlowField* flow, const WindowFrustum& window) {
  return flow != nullptr && is_of_stream(&flow->vectors, 2, window) &&
         is_of_stream(&flow->confidence, 1, window);
}

// The pixels of the stream behind n pixels of the window, from (y, x) on.
BlockRow blocks_of(const Image<float>& picture, int channel, int y, int x, int n, int step) {
  BlockRow blocks;
  blocks.step = step, blocks.cols = std::min(n * step, picture.cols() - x * step);
  for (int k = 0; k < step; ++k)
    blocks.row[k] = picture.row(channel, std::min(y * step + k, picture.rows() - 1)) + x * step;
  return blocks;
}

// How a base's displacement from one frame's view to another's changes with the anchor: what it leads to, at
// the surface's inverse depth, is the same pixel.
class Reanchoring {
 public:
  Reanchoring(const WindowFrustum& frustum, const RigidTransform& T_old_here,
              const RigidTransform& T_old_there, const RigidTransform& T_new_old)
      : here_(frustum, T_old_here),
        there_(frustum, T_old_there),
        here_new_(frustum, T_new_old * T_old_here),
        there_new_(frustum, T_new_old * T_old_there),
        unit_{frustum.u_per_px(), frustum.v_per_px()} {}

  // shift[2]: pixels of the old anchor, becomes those of the new one.
  void carry(int x, int y, float surface, float* shift) const {
    const double q = static_cast<double>(surface), start[2] = {x + 0.5, y + 0.5};
    double point[3], end[3], x_end[3];
    here_.place(start, q, point);
    for (std::size_t a = 0; a < 2; ++a) point[a] += static_cast<double>(shift[a]) * unit_[a];
    there_.project(point, end, nullptr);
    here_new_.place(start, q, point);
    there_new_.place(end, q, x_end);
    for (std::size_t a = 0; a < 2; ++a)
      shift[a] = std::clamp(static_cast<float>((x_end[a] - point[a]) / unit_[a]), -kMostShift, kMostShift);
  }

 private:
  ViewGeometry<double> here_, there_, here_new_, there_new_;
  double unit_[2];
};

}  // namespace

void WindowFrame::copy_from(const WindowFrame& other) {
  index = other.index, slot = other.slot, time_s = other.time_s;
  exposure = other.exposure, blur_fraction = other.blur_fraction;
  T_world_camera = other.T_world_camera, T_anchor_camera = other.T_anchor_camera;
  values.copy_from(other.values);
  base.copy_from(other.base);
  guide.copy_from(other.guide);
  prior_guides.copy_from(other.prior_guides);
  depth_prior.copy_from(other.depth_prior);
  for (int k = 0; k < 2; ++k) has_flow[k] = other.has_flow[k];
  dynamic_share = other.dynamic_share;
}

int WindowFrames::nearest(double time_s) const {
  int best = 0;
  for (int i = 1; i < size(); ++i)
    if (std::abs(frame(i).time_s - time_s) < std::abs(frame(best).time_s - time_s)) best = i;
  return best;
}

RigidTransform WindowFrames::T_anchor_camera(const RigidTransform& T_world_camera) const {
  return T_world_anchor_.inverse() * T_world_camera;
}

Window::Window(const WindowFrustum& frustum, const WindowOptions& options)
    : WindowFrames(frustum), options_(options) {
  HDRCAM_CHECK(options.frames >= WindowOptions::kFewestFrames &&
               options.frames <= WindowOptions::kMostFrames);
  HDRCAM_CHECK(frustum.rows > 0 && frustum.cols > 0 && frustum.camera.fx_px > 0 && frustum.camera.fy_px > 0);
  HDRCAM_CHECK(frustum.step_px == 1 || frustum.step_px == 2 || frustum.step_px == 4 ||
               frustum.step_px == kMostStep);
  for (int i = 0; i < slots(); ++i) storage_.push_back(make_frame());
  order_.reserve(storage_.size());
}

std::unique_ptr<WindowFrame> Window::make_frame() const {
  const int guide_rows = std::max(frustum_.rows / kGuideStep, 1),
            guide_cols = std::max(frustum_.cols / kGuideStep, 1);
  auto frame = std::make_unique<WindowFrame>();
  frame->values = Image<float>(3, frustum_.rows, frustum_.cols);
  frame->base = Image<BasePixel>(1, frustum_.rows, frustum_.cols);
  frame->guide = Image<float>(1, guide_rows, guide_cols);
  frame->prior_guides = Image<std::uint8_t>(1, guide_rows, guide_cols);
  return frame;
}

WindowFrame& Window::spare() {
  for (const auto& frame : storage_)
    if (frame->holders == 0 && std::find(order_.begin(), order_.end(), frame.get()) == order_.end())
      return *frame;
  storage_.push_back(make_frame());
  return *storage_.back();
}

WindowFrame& Window::writable(int i) {
  WindowFrame*& frame = order_[static_cast<std::size_t>(i)];
  if (frame->holders == 0) return *frame;
  WindowFrame& copy = spare();
  copy.copy_from(*frame);
  frame = &copy;
  return copy;
}

void Window::hold(WindowFrames& held) {
  release(held);
  held.order_.reserve(storage_.size());
  held.order_.assign(order_.begin(), order_.end());
  held.T_world_anchor_ = T_world_anchor_;
  for (WindowFrame* frame : held.order_) ++frame->holders;
}

void Window::release(WindowFrames& held) {
  for (WindowFrame* frame : held.order_) --frame->holders;
  held.order_.clear();
}

Result<void> Window::advance(const FieldObservation& seen, WorkerPool& pool) {
  for (const Image<float>* picture : {seen.codes, seen.radiance, seen.variance})
    if (!is_of_stream(picture, 3, frustum_))
      return Error{
          ErrorCode::Invalid,
          fmt::format("the pictures of frame {} for the field are not 3 x {} x {}; start a "
                      "new field for another size",
                      seen.index, frustum_.rows * frustum_.step_px, frustum_.cols * frustum_.step_px)};
  if (!std::isfinite(seen.exposure) || seen.exposure <= 0)
    return Error{
        ErrorCode::BadExposure,
        fmt::format("frame {} has the relative exposure {}; it must be positive", seen.index, seen.exposure)};
  if (static_cast<int>(order_.size()) == options_.frames) order_.erase(order_.begin());
  WindowFrame& frame = spare();
  frame.slot = static_cast<int>(arrived_++ % slots());
  const WindowFrame* previous = order_.empty() ? nullptr : order_.back();
  order_.push_back(&frame);

  frame.index = seen.index;
  frame.time_s = std::isfinite(seen.time_s) ? seen.time_s : 0;
  if (previous != nullptr && frame.time_s <= previous->time_s) frame.time_s = previous->time_s + kLeastStep_s;
  frame.exposure = seen.exposure;
  frame.blur_fraction = std::isfinite(seen.blur_fraction) ? std::clamp(seen.blur_fraction, 0.f, 1.f) : 0;
  frame.T_world_camera = seen.T_world_camera.is_rigid() ? seen.T_world_camera
                         : previous != nullptr          ? previous->T_world_camera
                                                        : RigidTransform();
  if (previous == nullptr) T_world_anchor_ = frame.T_world_camera;
  frame.T_anchor_camera = T_anchor_camera(frame.T_world_camera);
  take_base(seen, frame, pool);
  if (previous != nullptr && usable(seen.to_previous, frustum_))
    carry_guide(frustum_, *previous, *seen.to_previous, frame);
  else
    frame.guide.fill(options_.default_inverse_depth);
  guide_by_prior(frustum_, frame);
  take_surface(frustum_, frame, pool);
  if (previous != nullptr) {
    if (usable(seen.to_previous, frustum_))
      take_flow(*seen.to_previous, frame, *previous, Neighbour::Previous, pool);
    if (usable(seen.from_previous, frustum_))
      take_flow(*seen.from_previous, writable(size() - 2), frame, Neighbour::Next, pool);
  }
  return {};
}

void Window::take_base(const FieldObservation& seen, WindowFrame& frame, WorkerPool& pool) const {
  const WindowKernels& kernels = window_kernels();
  const int step = frustum_.step_px;
  for_runs(pool, frustum_.rows, frustum_.cols, [&](int y, int x, int n) {
    BasePixel* const base = &frame.base.at(0, y, x);
    for (int i = 0; i < n; ++i) base[i].fill(0);
    for (int c = 0; c < 3; ++c) {
      float* const values = frame.values.row(c, y) + x;
      alignas(64) float mean[kRun], spread[kRun], log_radiance[kRun], gate[kRun];
      BaseRow row{.radiance = mean,
                  .variance = spread,
                  .unseen_from = seen.unseen_variance,
                  .trusted_sigma = options_.trusted_sigma,
                  .log_radiance = log_radiance,
                  .gate = gate};
      if (step == 1) {
        kernels.values({.codes = seen.codes->row(c, y) + x, .no_value = kNoValue, .values = values}, n);
        row.radiance = seen.radiance->row(c, y) + x, row.variance = seen.variance->row(c, y) + x;
      } else {
        kernels.block_values({.codes = blocks_of(*seen.codes, c, y, x, n, step),
                              .clipped = kClippedCode,
                              .no_value = kNoValue,
                              .values = values},
                             n);
        kernels.block_state({.radiance = blocks_of(*seen.radiance, c, y, x, n, step),
                             .variance = blocks_of(*seen.variance, c, y, x, n, step),
                             .unseen_from = seen.unseen_variance,
                             .mean = mean,
                             .variance_of_mean = spread},
                            n);
      }
      kernels.base(row, n);
      for (int i = 0; i < n; ++i) {
        base[i][kBaseLogRadiance + static_cast<std::size_t>(c)] = log_radiance[i];
        base[i][kBaseGate + static_cast<std::size_t>(c)] = gate[i];
      }
    }
  });
  frame.has_flow[0] = frame.has_flow[1] = false;
  frame.dynamic_share = 0;
  frame.depth_prior.reshape(0, 0, 0);
  if (seen.inverse_depth != nullptr && seen.inverse_depth->same_shape(frame.base))
    frame.depth_prior.copy_from(*seen.inverse_depth);
}

// Lifts a flow of pixels to a displacement in window space: both of its ends lie at the best known inverse
// depth of its beginning, each in its own camera; the change of depth in between is left out. The reverse
// flow starts as its opposite until it is measured: motion is nearly uniform over two frames.
void Window::take_flow(const FlowField& flow, WindowFrame& from, const WindowFrame& to, Neighbour which,
                       WorkerPool& pool) const {
  const Intrinsics& camera = frustum_.camera;
  const ViewGeometry<float> here(frustum_, from.T_anchor_camera), there(frustum_, to.T_anchor_camera);
  const auto k = static_cast<std::size_t>(which), other = 1 - k;
  const int step = frustum_.step_px;
  const float static_limit = kStatic_px / static_cast<float>(step);
  std::atomic<int> dynamic = 0;
  for_runs(pool, frustum_.rows, frustum_.cols, [&](int y, int x, int n) {
    BasePixel* const base = &from.base.at(0, y, x);
    alignas(64) float surface[kRun], dx[kRun], dy[kRun], u[kRun], v[kRun], sure[kRun], mean_confidence[kRun];
    for (int i = 0; i < n; ++i) surface[i] = base[i][kBaseSurface];
    if (step > 1)
      window_kernels().block_flow({.dx = blocks_of(flow.vectors, 0, y, x, n, step),
                                   .dy = blocks_of(flow.vectors, 1, y, x, n, step),
                                   .confidence = blocks_of(flow.confidence, 0, y, x, n, step),
                                   .mean_dx = dx,
                                   .mean_dy = dy,
                                   .confidence_of_mean = mean_confidence},
                                  n);
    const LiftedRow row{.dx = step > 1 ? dx : flow.vectors.row(0, y) + x,
                        .dy = step > 1 ? dy : flow.vectors.row(1, y) + x,
                        .confidence = step > 1 ? mean_confidence : flow.confidence.row(0, y) + x,
                        .surface = surface,
                        .x = static_cast<float>(x) + 0.5f,
                        .y = static_cast<float>(y) + 0.5f,
                        .here = here.to_anchor(),
                        .there = there.to_anchor(),
                        .focal = {static_cast<float>(camera.fx_px), static_cast<float>(camera.fy_px)},
                        .centre = {static_cast<float>(camera.cx_px), static_cast<float>(camera.cy_px)},
                        .nearest = ViewGeometry<float>::kNearest,
                        .most = kMaxFlow_px / static_cast<float>(step),
                        .u = u,
                        .v = v,
                        .sure = sure};
    window_kernels().lift(row, n);
    int dynamic_here = 0;
    for (int i = 0; i < n; ++i) {
      base[i][kBaseFlow + 2 * k] = u[i], base[i][kBaseFlow + 2 * k + 1] = v[i];
      if (!from.has_flow[other])
        base[i][kBaseFlow + 2 * other] = -u[i], base[i][kBaseFlow + 2 * other + 1] = -v[i];
      base[i][kBaseConfidence + k] = sure[i];
      dynamic_here += std::abs(u[i]) > static_limit || std::abs(v[i]) > static_limit;
    }
    dynamic.fetch_add(dynamic_here, std::memory_order_relaxed);
  });
  from.dynamic_share =
      std::max(from.dynamic_share, static_cast<float>(dynamic.load()) / static_cast<float>(from.base.size()));
  from.has_flow[k] = true;
}

RigidTransform Window::move_anchor() {
  HDRCAM_CHECK(!order_.empty());
  const RigidTransform T_world_new = newest().T_world_camera;
  const RigidTransform T_new_old = T_world_new.inverse() * T_world_anchor_;
  for (int i = 0; i < size(); ++i) {
    WindowFrame& lifted = writable(i);
    for (const Neighbour neighbour : {Neighbour::Next, Neighbour::Previous}) {
      const int j = neighbour_of(i, neighbour);
      if (j < 0 || j >= size()) continue;
      const Reanchoring way(frustum_, frame(i).T_anchor_camera, frame(j).T_anchor_camera, T_new_old);
      for (int y = 0; y < frustum_.rows; ++y)
        for (int x = 0; x < frustum_.cols; ++x) {
          BasePixel& base = lifted.base.at(0, y, x);
          way.carry(x, y, base[kBaseSurface], &base[kBaseFlow + 2 * static_cast<std::size_t>(neighbour)]);
        }
    }
  }
  T_world_anchor_ = T_world_new;
  for (WindowFrame* frame : order_) frame->T_anchor_camera = T_world_new.inverse() * frame->T_world_camera;
  return T_new_old;
}

bool Window::anchor_is_stale() const {
  if (order_.empty()) return false;
  const ViewGeometry<double> view(frustum_, newest().T_anchor_camera);
  for (int corner = 0; corner < 4; ++corner) {
    const double pixel[2] = {corner & 1 ? frustum_.cols : 0.0, corner & 2 ? frustum_.rows : 0.0};
    double x[3];
    view.place(pixel, static_cast<double>(options_.default_inverse_depth), x);
    if (x[0] < 0 || x[0] > 1 || x[1] < 0 || x[1] > 1) return true;
  }
  return false;
}

bool WindowFrames::has_parallax() const {
  constexpr double kVisible_px = 0.5;
  for (const WindowFrame* frame : order_) {
    const double moved = frame->T_anchor_camera.t.norm();
    if (moved / static_cast<double>(frustum_.near) * frustum_.camera.fx_px * frustum_.step_px > kVisible_px)
      return true;
  }
  return false;
}

bool WindowFrames::has_motion() const {
  constexpr float kMoving = 1e-3f;  // share of the pixels
  return std::any_of(order_.begin(), order_.end(),
                     [](const WindowFrame* frame) { return frame->dynamic_share > kMoving; });
}

}  // namespace hdrcam
