#include "firmware_host/film/virtual_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "render/views/re_exposure.h"
#include "render/white_balance.h"

namespace hdrcam {
namespace {

constexpr double kSameTime_s = 1e-7;
constexpr double kSameShare = 1e-5;  // of an interval: so near to its end a frame is shown as it is
// What nearly all pixels do is found from some: from every 7th of a flow, every 3rd along both axes of a way.
constexpr std::size_t kFlowStride = 7;
constexpr int kWayStep_px = 3;

template <class T>
void side_by_side(const Image<T>& left, const Image<T>& right, Image<T>& both) {
  both.reshape(left.channels(), left.rows(), 2 * left.cols());
  for (int c = 0; c < left.channels(); ++c)
    for (int y = 0; y < left.rows(); ++y) {
      std::copy_n(left.row(c, y), left.cols(), both.row(c, y));
      std::copy_n(right.row(c, y), left.cols(), both.row(c, y) + left.cols());
    }
}

// What nearly all of them stay within; 0 where there are none.
double nearly_greatest(std::vector<float>& values) {
  constexpr std::size_t kNearlyAll = 99;  // of 100
  if (values.empty()) return 0;
  const auto high = values.begin() + static_cast<std::ptrdiff_t>(values.size() * kNearlyAll / 100);
  std::nth_element(values.begin(), high, values.end());
  return static_cast<double>(*high);
}

// How far a point goes in the picture from view to view; 0 where one of them has it behind itself. ray:
// through it, with a z of 1; views: of the camera that ray and depth are of, as each of them sees it.
double seen_way_px(const Eigen::Vector3d& ray, double inverse_depth, std::span<const RigidTransform> views,
                   const Intrinsics& lens) {
  constexpr double kNearest = 1e-3;  // z over that of the ray
  double way_px = 0;
  std::optional<Eigen::Vector2d> last_px;
  for (const RigidTransform& T_view_recorded : views) {
    const Eigen::Vector3d seen = T_view_recorded.R * ray + T_view_recorded.t * inverse_depth;
    if (seen.z() < kNearest) return 0;
    const Eigen::Vector2d at_px(lens.fx_px * seen.x() / seen.z(), lens.fy_px * seen.y() / seen.z());
    if (last_px) way_px += (at_px - *last_px).norm();
    last_px = at_px;
  }
  return way_px;
}

}  // namespace

VirtualCamera::VirtualCamera(const FilmPlan& plan, const std::optional<ChannelGains>& white_balance,
                             WorkerPool& pool)
    : plan_(plan), white_balance_(white_balance), maker_(pool), renderer_(pool) {}

Result<void> VirtualCamera::take(const HdrFrame& frame, const FrameEstimate& estimate,
                                 const Response& response, const Show& show) {
  std::unique_ptr<Keyframe> key;
  if (spare_.empty())
    key = std::make_unique<Keyframe>();
  else
    key = std::move(spare_.back()), spare_.pop_back();
  take_keyframe(frame, estimate, *key);
  field_ = estimate.field.snapshot();
  maker_.complete(field_, keys_.empty() ? nullptr : keys_.back().get(), *key);
  add_to_path(*key);
  keep_response(key->time_s, response);
  keys_.push_back(std::move(key));
  copy(estimate.frame, input_);
  while (!done() && ready(shown_)) TRY(film(show));
  drop_old();
  return {};
}

void VirtualCamera::take(SceneSnapshot& scene) {
  for (const PathPose& pose : scene.path) steady_.add(pose.time_s, pose.T_world_camera, pose.world);
  for (Keyframe& key : scene.frames) {
    add_to_path(key);
    keys_.push_back(std::make_unique<Keyframe>(std::move(key)));
  }
  if (scene.field != nullptr) field_ = SnapshotHold(*scene.field);
  if (scene.response) keep_response(0, *scene.response);
  copy(scene.input, input_);
}

void VirtualCamera::add_to_path(const Keyframe& key) {
  steady_.add(key.time_s, key.T_world_camera, key.world,
              key.frame.pose ? SteadyPath::Is::Posed : SteadyPath::Is::HeldInPlace);
}

Result<void> VirtualCamera::finish(const Show& show) {
  while (!done() && !keys_.empty()) TRY(film(show));
  return {};
}

VirtualCamera::ExposureInterval VirtualCamera::exposure_of(int frame) const {
  const double centre_s = plan_.first.seconds() + plan_.scene_s(frame);
  const double half_s = 0.5 * plan_.scene_shutter_s();
  return {centre_s - half_s, centre_s + half_s};
}

bool VirtualCamera::ready(int frame) const {
  const double later_s = plan_.stabilize ? SteadyPath::kReach_s : 0;
  return keys_.back()->time_s + kSameTime_s >= exposure_of(frame).to_s + later_s;
}

// The frames before the next film frame's exposure are no longer needed, but the one that it begins after.
void VirtualCamera::drop_old() {
  const double needed_s = done() ? keys_.back()->time_s : exposure_of(shown_).from_s;
  while (keys_.size() > 2 && keys_[1]->time_s <= needed_s + kSameTime_s) {
    spare_.push_back(std::move(keys_.front()));
    keys_.pop_front();
  }
  steady_.forget_before(keys_.front()->time_s);
  while (responses_.size() > 1 && responses_[1].from_s <= keys_.front()->time_s) responses_.pop_front();
}

void VirtualCamera::keep_response(double from_s, const Response& response) {
  const auto is_last = [&](int c) { return responses_.back().response.inverse(c) == response.inverse(c); };
  if (!responses_.empty() && is_last(0) && is_last(1) && is_last(2)) return;
  responses_.push_back({from_s, response});
}

// A response that was learned anew does not fit the radiance of the frames before.
const Response& VirtualCamera::response_of(const Keyframe& key) const {
  const auto later = std::ranges::upper_bound(responses_, key.time_s, {}, &ResponseInUse::from_s);
  return later == responses_.begin() ? later->response : (later - 1)->response;
}

KeyframeInterval VirtualCamera::interval_at(double time_s) const {
  const auto after = std::ranges::lower_bound(keys_, time_s - kSameTime_s, {}, &Keyframe::time_s);
  if (after == keys_.begin()) return {nullptr, keys_.front().get(), 1};
  if (after == keys_.end()) return {keys_.back().get(), nullptr, 0};
  const Keyframe &a = **(after - 1), &b = **after;
  const double share = std::clamp((time_s - a.time_s) / (b.time_s - a.time_s), 0.0, 1.0);
  if (a.world != b.world)  // nothing lies between them
    return share < 0.5 ? KeyframeInterval{&a, nullptr, 0} : KeyframeInterval{nullptr, &b, 1};
  return {&a, &b, share > 1 - kSameShare ? 1 : share};
}

RigidTransform VirtualCamera::T_world_view(const KeyframeInterval& interval, double playback_s,
                                           Eye eye) const {
  const RigidTransform T_world_recorded =
      plan_.stabilize ? steady_.at(interval.time_s()) : interval.T_world_camera();
  RigidTransform T_view_eye;
  T_view_eye.t.x() = 0.5 * static_cast<int>(eye) * plan_.baseline;
  return T_world_recorded * plan_.view.at(playback_s).T_recorded_view() * T_view_eye;
}

// How far nearly every pixel moves in a second from one recorded frame to the next, in pixels of the film; 0
// where nothing is known of it.
double VirtualCamera::speed_px_s(const Keyframe& before, const Keyframe& after) const {
  const Image<float>& flow = after.to_previous.vectors;
  if (flow.empty() || before.world != after.world) return 0;
  std::vector<float> lengths;
  for (std::size_t i = 0; i < flow.plane_size(); i += kFlowStride)
    lengths.push_back(std::hypot(flow.plane(0)[i], flow.plane(1)[i]));
  const double enlarged = filming_lens(after).fx_px / after.lens.fx_px;
  return nearly_greatest(lengths) * enlarged / (after.time_s - before.time_s);
}

// How far that is in an exposure, which may lie in many intervals of recorded frames: the fastest counts.
double VirtualCamera::recorded_way_px(const ExposureInterval& exposure) const {
  double fastest_px_s = 0;
  for (std::size_t i = 1; i < keys_.size(); ++i) {
    const Keyframe &before = *keys_[i - 1], &after = *keys_[i];
    if (after.time_s > exposure.from_s + kSameTime_s && before.time_s < exposure.to_s - kSameTime_s)
      fastest_px_s = std::max(fastest_px_s, speed_px_s(before, after));
  }
  return fastest_px_s * (exposure.to_s - exposure.from_s);
}

// How far nearly every pixel of the recorded picture moves in the film's while the path moves the view during
// an exposure.
double VirtualCamera::path_way_px(int frame) const {
  if (!plan_.view.is_path()) return 0;
  const KeyframeInterval interval = interval_at(plan_.first.seconds() + plan_.scene_s(frame));
  const Keyframe& key = interval.nearest();
  const double half_s = 0.5 * plan_.shutter_s, centre_s = plan_.playback_s(frame);
  std::array<RigidTransform, 3> views;  // recorded to virtual camera: at the begin, the centre and the end
  for (std::size_t i = 0; i < views.size(); ++i)
    views[i] = plan_.view.at(centre_s + half_s * (static_cast<double>(i) - 1)).T_recorded_view().inverse();
  const Intrinsics lens = filming_lens(key);
  const int rows = key.inverse_depth.rows(), cols = key.inverse_depth.cols();
  std::vector<float> ways;
  for (int y = 0; y < rows; y += kWayStep_px)
    for (int x = 0; x < cols; x += kWayStep_px) {
      const Eigen::Vector3d ray((x + 0.5 - key.lens.cx_px) / key.lens.fx_px,
                                (y + 0.5 - key.lens.cy_px) / key.lens.fy_px, 1);
      const auto inverse_depth = static_cast<double>(key.inverse_depth.at(0, y, x));
      ways.push_back(static_cast<float>(seen_way_px(ray, inverse_depth, views, lens)));
    }
  return nearly_greatest(ways);
}

// Enough that nothing moves more than a pixel and a half from one instant to the next.
int VirtualCamera::instants(int frame) const {
  constexpr double kStep_px = 1.5;
  constexpr int kLeast = 3, kMost = 33;
  const double way_px = recorded_way_px(exposure_of(frame)) + path_way_px(frame);
  return std::clamp(static_cast<int>(std::ceil(std::min(way_px / kStep_px, 1.0 * kMost))), kLeast, kMost) | 1;
}

// One eye's frame: the mean of the instants of its exposure; everything but the radiance is the centre's.
void VirtualCamera::expose(int frame, Eye eye, HdrFrame& out) {
  const ExposureInterval exposure = exposure_of(frame);
  const Keyframe& newest = *keys_.back();
  SceneView view;
  view.rows = plan_.height, view.cols = plan_.width;
  view.lens = filming_lens(newest);
  const auto show_at = [&](double time_s, double playback_s, HdrFrame& picture) {
    const KeyframeInterval interval = interval_at(time_s);
    view.T_world_camera = T_world_view(interval, playback_s, eye);
    const bool known = interval.nearest().world == newest.world;
    renderer_.render(interval, view, known ? field_ : SnapshotHold(), picture);
  };
  const double centre_s = 0.5 * (exposure.from_s + exposure.to_s);
  const double playback_s = plan_.playback_s(frame);
  show_at(centre_s, playback_s, out);
  if (!(plan_.shutter_s > 0)) return;
  const int count = instants(frame);
  sum_.copy_from(out.radiance);
  for (int i = 0; i < count; ++i) {
    if (i == count / 2) continue;  // the centre
    const double share = (i + 0.5) / count;
    show_at(exposure.from_s + share * (exposure.to_s - exposure.from_s),
            playback_s + (share - 0.5) * plan_.shutter_s, instant_);
    for (std::size_t p = 0; p < sum_.size(); ++p) sum_.samples()[p] += instant_.radiance.samples()[p];
  }
  for (std::size_t p = 0; p < sum_.size(); ++p)
    out.radiance.samples()[p] = sum_.samples()[p] / static_cast<float>(count);
}

void VirtualCamera::join_eyes() {
  side_by_side(left_.radiance, instant_.radiance, frame_.radiance);
  side_by_side(left_.sigma, instant_.sigma, frame_.sigma);
  side_by_side(left_.depth, instant_.depth, frame_.depth);
  side_by_side(left_.provenance, instant_.provenance, frame_.provenance);
}

Result<void> VirtualCamera::film(const Show& show) {
  if (plan_.baseline > 0) {
    expose(shown_, Eye::Left, left_);
    expose(shown_, Eye::Right, frame_);
    std::swap(instant_, frame_);
    join_eyes();
  } else {
    expose(shown_, Eye::Middle, frame_);
  }
  label(shown_);
  FrameRecord record;
  describe_frame(frame_, plan_.playback_s(shown_), record);
  pixels_ += frame_.provenance.size();
  filled_pixels_ += static_cast<std::uint64_t>(
      std::ranges::count(frame_.provenance.samples(), static_cast<std::uint8_t>(Provenance::Field)));
  ++shown_;
  return show(frame_, input_, record);
}

// The film has its own numbers and times; exposure and white are those of the nearest frame, but of pictures
// that are exposed anew.
void VirtualCamera::label(int frame) {
  const KeyframeInterval interval = interval_at(plan_.first.seconds() + plan_.scene_s(frame));
  const HdrFrame& nearest = interval.nearest().frame;
  frame_.head() = nearest.head();
  frame_.facts.sequence = static_cast<std::uint64_t>(frame);
  frame_.facts.timestamp = Instant::from_seconds(plan_.playback_s(frame));
  frame_.facts.flags = 0;
  frame_.recorded_s = plan_.scene_s(frame);
  state_camera(interval, plan_.playback_s(frame));
  if (plan_.exposure) frame_.neutral_gains.reset();  // the response makes the camera's own codes of the light
  balance_colours(white_balance_, frame_);
  if (!plan_.exposure) return;
  const double exposure = *plan_.exposure > 0 ? *plan_.exposure : frame_.reference_exposure;
  frame_.facts.exposure_s = exposure;
  frame_.facts.analogue_gain = frame_.facts.digital_gain = 1;
  frame_.exposure = static_cast<float>(exposure / frame_.reference_exposure);
  expose_again(exposure / frame_.reference_exposure, response_of(interval.nearest()), frame_.radiance);
}

// Where the virtual camera stands and what its lens is. Poses are stated in the recording's world, which need
// not be the method's. What lies between two frames is known as far as both are: a frame without a pose was
// taken to be where the one before it was.
void VirtualCamera::state_camera(const KeyframeInterval& interval, double playback_s) {
  const Keyframe& key = interval.nearest();
  frame_.facts.T_world_camera.reset();  // of the recorded camera
  frame_.lens.reset();                  // two eyes have none in common
  if (!(plan_.baseline > 0)) frame_.lens = filming_lens(key);
  if (!frame_.pose) return;
  if (interval.lies_between()) {
    const std::optional<FramePose>&before = interval.before->frame.pose, &after = interval.after->frame.pose;
    if (!before || !after) return frame_.pose.reset();
    frame_.pose->lost = before->lost || after->lost;
  }
  const RigidTransform T_stated_world = frame_.pose->T_world_camera * key.T_world_camera.inverse();
  frame_.pose->T_world_camera = T_stated_world * T_world_view(interval, playback_s, Eye::Middle);
}

// The recorded lens for the film's size: the picture is covered, and cropped where its shape differs.
Intrinsics VirtualCamera::filming_lens(const Keyframe& key) const {
  const Intrinsics& lens = key.lens;
  const double rows = key.inverse_depth.rows(), cols = key.inverse_depth.cols();
  const double scale = std::max(plan_.width / cols, plan_.height / rows);
  return {lens.fx_px * scale, lens.fy_px * scale, (lens.cx_px - 0.5 * cols) * scale + 0.5 * plan_.width,
          (lens.cy_px - 0.5 * rows) * scale + 0.5 * plan_.height};
}

}  // namespace hdrcam
