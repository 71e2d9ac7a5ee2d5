#include "hal/real/camera_v4l2.h"

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <mutex>
#include <utility>
#include <vector>

#include "hal/real/buffer_slots.h"
#include "hal/real/control_pacer.h"
#include "hal/real/control_refusals.h"
#include "hal/real/media_graph.h"
#include "hal/real/recent_stamp.h"
#include "hal/real/sensor_path.h"
#include "hal/real/stream_errors.h"
#include "hal/real/v4l2_modes.h"
#include "hal/real/v4l2_stream.h"

namespace hdrcam {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr short kFails = POLLERR | POLLHUP;  // of poll()

// The nodes of one camera: the capture node and the nodes that the media graph connects to it.
struct Nodes {
  DeviceNode video;
  V4l2Identity identity;
  std::optional<MediaGraph> graph;
  std::optional<DeviceNode> media, sensor;
  std::optional<Error> forbidden;  // a media node, which may be that of the graph
};

Result<Nodes> open_nodes(const std::string& path, const V4l2Options& options) {
  auto video = TRY(DeviceNode::open(path));
  auto identified = identify(video);
  if (!identified && identified.error().sys_errno == ENOTTY)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' is not a camera; 'hdrcam list' shows those that there are", path), ENOTTY};
  auto identity = TRY(std::move(identified));
  if (identity.queue_type == 0)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' ({}) is not a camera that streams; 'hdrcam list' shows those that are",
                             path, identity.card)};
  Nodes nodes{std::move(video), std::move(identity), {}, {}, {}, {}};
  auto graph = media_graph_of(path, options.media_nodes);
  if (!graph && graph.error().code == ErrorCode::Permission) nodes.forbidden = graph.error();
  if (!graph || !graph->has_value())
    return nodes;  // no accessible media controller: the capture node suffices, or configure() says so
  nodes.graph = std::move(**graph);
  if (auto media = DeviceNode::open(nodes.graph->node); media.ok()) nodes.media = std::move(*media);
  if (!nodes.graph->sensor_node.empty()) nodes.sensor = TRY(DeviceNode::open(nodes.graph->sensor_node));
  return nodes;
}

// The buffer's flags say "monotonic", or (old drivers) nothing.
Instant instant_of_stamp(Clock& clock, std::uint32_t buffer_flags, Duration stamp) {
  if ((buffer_flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
    return instant_of_recent_stamp(clock, ClockDomain::Monotonic, stamp);
  return instant_of_recent_stamp(clock, stamp);
}

class V4l2Camera : public Camera, private BufferLease::Owner {
 public:
  V4l2Camera(Nodes nodes, const V4l2Options& options, Clock& clock)
      : nodes_(std::move(nodes)),
        clock_(clock),
        control_(options.exposure_control
                     ? ExposureControl::of_private(nodes_.video, *options.exposure_control)
                 : nodes_.sensor ? ExposureControl::of_sensor(*nodes_.sensor, nodes_.graph->sensor_name)
                                 : ExposureControl::of_video_node(nodes_.video)),
        stream_(nodes_.video, media_for_requests(options), nodes_.identity.queue_type) {
    capabilities_.id = nodes_.video.path();
    capabilities_.model = nodes_.sensor ? nodes_.graph->sensor_name : nodes_.identity.card;
    capabilities_.driver = nodes_.identity.driver;
    capabilities_.modes = modes_of(nodes_.video, nodes_.identity.queue_type);
    if (nodes_.identity.media_controlled && nodes_.sensor && !nodes_.graph->path.empty())
      capabilities_.modes =
          modes_of_sensor(*nodes_.sensor, nodes_.graph->path.front().index, capabilities_.modes);
    control_.describe(capabilities_);
  }
  ~V4l2Camera() override {
    (void)V4l2Camera::stop();
    control_.give_back();
  }

  const CameraCapabilities& capabilities() const override { return capabilities_; }

  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override {
    const std::lock_guard lock(mutex_);
    TRY(check_configurable(wanted, buffers));
    TRY(check_sensor_reached());
    slots_.reset(0);
    TRY(stream_.allocate(0));  // a queue with buffers keeps its format
    const StreamMode sent = nodes_.graph ? TRY(set_format_along(nodes_.graph->path, wanted)) : wanted;
    picture_ = TRY(set_mode(nodes_.video, nodes_.identity.queue_type, sent));
    StreamMode& mode = picture_.mode;
    TRY(control_.take_over());
    if (const auto fixed = TRY(control_.fix_frame_duration(mode.width, mode.height, wanted.frame_duration)))
      mode.frame_duration = *fixed;
    control_.describe(capabilities_);
    TRY(stream_.allocate(buffers));
    capabilities_.buffers = stream_.buffers();
    capabilities_.exposure_per_request = capabilities_.reports_exposure = stream_.takes_requests();
    capabilities_.timestamp_mark = stream_.timestamp_mark();
    slots_.reset(static_cast<std::size_t>(stream_.buffers()));
    return mode;
  }

  Result<void> start() override {
    const std::lock_guard lock(mutex_);
    if (started_) return already_started(capabilities_.id);
    if (slots_.empty()) return not_configured(capabilities_.id);
    slots_.free_queued();
    pacer_.restart(), refusals_.restart(), last_write_ = {}, wake_.clear();
    TRY(stream_.start());
    started_ = true;
    return {};
  }

  Result<void> queue(const ExposureRequest& request) override {
    const std::lock_guard lock(mutex_);
    if (!started_) return not_started(capabilities_.id);
    TRY(std::exchange(last_write_, {}));
    TRY(check_exposure(capabilities_, request));
    const std::size_t slot = TRY(slots_.free_one());
    const int index = static_cast<int>(slot);
    if (capabilities_.exposure_per_request) {
      TRY(stream_.renew(index));
      TRY(control_.write(request, stream_.request_fd(index)));
    }
    TRY(stream_.queue(index));
    slots_.queue(slot, request.cookie);
    pacer_.queued(request);
    return write_due_exposure();
  }

  Result<CapturedBuffer> wait(Duration timeout) override {
    const auto deadline = SteadyClock::now() + timeout;
    for (short said = 0;;) {
      {
        const std::lock_guard lock(mutex_);
        if (!started_) return stopped(capabilities_.id);
        if (slots_.any_queued())
          if (const auto filled = TRY(stream_.dequeue())) return completed(*filled);
      }
      const auto left = deadline - SteadyClock::now();
      if (left <= Duration::zero())
        return (said & kFails) != 0 ? stream_fails(capabilities_.id, timeout)
                                    : no_frame_within(capabilities_.id, timeout);
      said = TRY(sleep_until_ready(left, said));
    }
  }

  Result<void> stop() override {
    const std::lock_guard lock(mutex_);
    if (!started_) return {};
    started_ = false;
    wake_.set();
    auto ended = stream_.stop();
    if (!ended && ended.error().code != ErrorCode::Unplugged) return ended;
    return {};
  }

 private:
  // nullptr where requests cannot set the exposure: the capture node has no control of it.
  const DeviceNode* media_for_requests(const V4l2Options& options) const {
    const bool on_capture_node = options.exposure_control.has_value() || !nodes_.sensor;
    return control_.exists() && on_capture_node && nodes_.media ? &*nodes_.media : nullptr;
  }

  void give_back(int index) override {
    const std::lock_guard lock(mutex_);
    slots_.free(static_cast<std::size_t>(index));
  }

  Result<void> check_configurable(const StreamMode& wanted, int buffers) const {
    if (started_) return must_stop_to_configure(capabilities_.id);
    TRY(check_buffers(buffers, VIDEO_MAX_FRAME));
    TRY(check_size(wanted));
    return slots_.check_none_leased();
  }

  Result<void> check_sensor_reached() const {
    if (!nodes_.forbidden || !needs_sensor_node(nodes_.identity, capabilities_)) return {};
    Error error = *nodes_.forbidden;
    error.message = fmt::format("the sensor of '{}' cannot be found: {}", nodes_.video.path(), error.message);
    return error;
  }

  // For controls that do not belong to a frame: writes the next frame's exposure once the previous frame is
  // complete. A device that does not take it is asked again at the next call, as long as that frame is not
  // complete; then the frame tells that its exposure was late. Not after a time-out: it takes seconds, in
  // which no frame is taken, and that frame is over.
  Result<void> write_due_exposure() {
    if (!control_.exists() || capabilities_.exposure_per_request) return {};
    const auto due = pacer_.due();
    if (!due) return {};
    const Result<void> wrote = control_.write(due->request);
    const Instant now = clock_.now();
    if (wrote) pacer_.written(*due, now);
    if (!wrote && wrote.error().sys_errno == ETIMEDOUT) pacer_.given_up(*due);
    return refusals_.answered(due->index, wrote, now);
  }

  // What poll() says of the device; 0: nothing. said: the last time, after which dequeue() had no frame. It
  // would say the same at once.
  Result<short> sleep_until_ready(Duration left, short said) {
    constexpr Duration kPause = std::chrono::milliseconds(5);
    bool waits_for_frame = false;
    {
      const std::lock_guard lock(mutex_);
      waits_for_frame = slots_.any_queued();
    }
    if (said != 0) (void)wake_.sleep(-1, std::min(left, kPause));
    const auto [woken, device] = wake_.sleep(waits_for_frame ? nodes_.video.fd() : -1, left);
    if ((device & kFails) == 0 || (woken & POLLIN) != 0) return device;
    const std::lock_guard lock(mutex_);  // dequeue() reports the error, unless stop() came first
    if (!started_) return device;
    v4l2_capability any{};
    TRY(nodes_.video.demand(VIDIOC_QUERYCAP, &any, "deliver frames"));
    return device;
  }

  CapturedBuffer completed(const V4l2Stream::Filled& filled) {
    CapturedBuffer buffer;
    buffer.cookie = slots_.lease(static_cast<std::size_t>(filled.index));
    buffer.lease = BufferLease(*this, filled.index);
    buffer.sequence = filled.sequence;
    buffer.timestamp = instant_of_stamp(clock_, filled.flags, filled.stamp);
    buffer.readout = control_.readout(picture_.mode.height);
    buffer.mode = picture_.mode, buffer.yuv = picture_.yuv, buffer.stride = picture_.stride;
    const auto whole = stream_.memory(filled.index);
    const auto memory = whole.subspan(std::min(filled.begin, whole.size()));
    const bool compressed = picture_.stride == 0;
    buffer.damaged =
        (filled.flags & V4L2_BUF_FLAG_ERROR) != 0 || (!compressed && filled.bytes < picture_.bytes);
    buffer.pixels = memory.first(std::min(memory.size(), compressed ? filled.bytes : picture_.bytes));
    buffer.dmabuf_fd = stream_.dmabuf_fd(filled.index);
    if (capabilities_.reports_exposure)
      if (const auto applied = control_.read(stream_.request_fd(filled.index)))
        buffer.exposure = applied->exposure, buffer.analogue_gain = applied->analogue_gain;
    if (const bool late = pacer_.completed(buffer.timestamp);
        control_.exists() && !capabilities_.exposure_per_request)
      buffer.control_late = late;
    last_write_ = write_due_exposure();  // this frame is complete anyway: the next queue() reports it
    return buffer;
  }

  Nodes nodes_;
  Clock& clock_;
  ExposureControl control_;
  V4l2Stream stream_;
  CameraCapabilities capabilities_;
  V4l2Picture picture_;
  WakeUp wake_;
  std::mutex mutex_;  // of all below, against stop() and leases given back by other threads
  bool started_ = false;
  BufferSlots slots_{nodes_.video.path()};
  ControlPacer pacer_;
  ControlRefusals refusals_;
  Result<void> last_write_;  // of an exposure, from within wait()
};

}  // namespace

Result<std::unique_ptr<Camera>> open_v4l2_camera(const std::string& node, const V4l2Options& options,
                                                 Clock& clock) {
  auto nodes = TRY(open_nodes(node, options));
  return std::unique_ptr<Camera>(std::make_unique<V4l2Camera>(std::move(nodes), options, clock));
}

}  // namespace hdrcam
