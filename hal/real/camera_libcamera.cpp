#include "hal/real/camera_libcamera.h"

#ifndef HDRCAM_HAVE_LIBCAMERA

namespace hdrcam {
namespace {
Error not_built() {
  return {ErrorCode::Unsupported,
          "this hdrcam was built without libcamera; install libcamera-dev and build again, or use a "
          "/dev/video node"};
}
}  // namespace

void show_libcamera_log() {}
Result<std::vector<CameraCapabilities>> list_libcamera_cameras() { return not_built(); }
Result<std::unique_ptr<Camera>> open_libcamera_camera(const std::string&) { return not_built(); }

}  // namespace hdrcam

#else

#include <libcamera/libcamera.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "hal/pixel_format_table.h"
#include "hal/pixel_pack.h"
#include "hal/real/buffer_slots.h"
#include "hal/real/completed_frames.h"
#include "hal/real/control_pacer.h"
#include "hal/real/libcamera_black.h"
#include "hal/real/libcamera_buffers.h"
#include "hal/real/libcamera_error.h"
#include "hal/real/libcamera_formats.h"
#include "hal/real/recent_stamp.h"
#include "hal/real/stream_errors.h"

namespace hdrcam {
namespace {

namespace lc = libcamera;
using std::chrono::microseconds;

bool log_shown = false;

// libcamera allows one manager in a process: all users share it, and the last one stops it.
Result<std::shared_ptr<lc::CameraManager>> camera_manager() {
  static std::mutex mutex;
  static std::weak_ptr<lc::CameraManager> running;
  const std::lock_guard lock(mutex);
  if (auto manager = running.lock()) return manager;
  if (!log_shown && std::getenv("LIBCAMERA_LOG_LEVELS") == nullptr) lc::logSetTarget(lc::LoggingTargetNone);
  std::shared_ptr<lc::CameraManager> manager(new lc::CameraManager, [](lc::CameraManager* ending) {
    ending->stop();
    delete ending;
  });
  if (const int code = manager->start(); code != 0)
    return Error{ErrorCode::Io, fmt::format("libcamera does not start: {}", std::strerror(-code)), -code};
  running = manager;
  return manager;
}

bool offers(const lc::Camera& camera, const lc::ControlId& id) {
  return camera.controls().find(id.id()) != camera.controls().end();
}
// Pipelines with image processing algorithms on the host schedule frames, and only they have frame durations.
bool has_algorithms(const lc::Camera& camera) { return offers(camera, lc::controls::FrameDurationLimits); }

void describe_exposure(const lc::Camera& camera, CameraCapabilities& capabilities) {
  capabilities.sets_exposure = offers(camera, lc::controls::ExposureTime);
  capabilities.reports_exposure = capabilities.sets_exposure && has_algorithms(camera);
  if (!capabilities.sets_exposure) return;
  const auto& exposure = camera.controls().at(lc::controls::ExposureTime.id());
  capabilities.exposure_min = microseconds(std::max(1, exposure.min().get<std::int32_t>()));
  capabilities.exposure_max = microseconds(exposure.max().get<std::int32_t>());
  capabilities.exposure_step = has_algorithms(camera) ? microseconds(1) : microseconds(100);
  // Without algorithms "AnalogueGain" is a slider position, 1 at the device's default and 4 at its highest,
  // whatever the amplification: it is not a factor and stays at 1.
  if (!has_algorithms(camera) || !offers(camera, lc::controls::AnalogueGain)) return;
  const auto& gain = camera.controls().at(lc::controls::AnalogueGain.id());
  capabilities.gain_min = gain.min().get<float>(), capabilities.gain_max = gain.max().get<float>();
}

void add_modes(lc::Camera& camera, lc::StreamRole role, CameraCapabilities& capabilities) {
  const auto configuration = camera.generateConfiguration({role});
  if (configuration == nullptr || configuration->empty()) return;
  Duration shortest = kUsualFrameDuration;
  if (has_algorithms(camera))
    shortest =
        microseconds(camera.controls().at(lc::controls::FrameDurationLimits.id()).min().get<std::int64_t>());
  const auto& formats = configuration->at(0).formats();
  for (const lc::PixelFormat& theirs : formats.pixelformats())
    if (const auto format = format_of(theirs))
      for (const lc::Size& size : formats.sizes(theirs))
        capabilities.modes.push_back(
            {*format, static_cast<int>(size.width), static_cast<int>(size.height), shortest});
}

CameraCapabilities capabilities_of(lc::Camera& camera) {
  CameraCapabilities capabilities;
  capabilities.id = camera.id(), capabilities.driver = "libcamera " + lc::CameraManager::version();
  capabilities.model = camera.properties().get(lc::properties::Model).value_or(camera.id());
  describe_exposure(camera, capabilities);
  add_modes(camera, lc::StreamRole::Viewfinder, capabilities);
  add_modes(camera, lc::StreamRole::Raw, capabilities);
  return capabilities;
}

// A sensor that is mounted upside down is flipped by libcamera, and lists the order of its colours as if it
// were not: the official cameras of the Raspberry Pi list RGGB and send BGGR.
bool stands_for(PixelFormat taken, PixelFormat wanted) {
  return taken == wanted || alike_but_for_order(taken, wanted);
}

// From libcamera's skew, the time between the exposures of the first row and the last one.
Duration readout_of(Duration skew, int rows, Duration frame_duration) {
  const Duration possible = std::clamp(skew, Duration(0), frame_duration);
  return rows > 1 ? std::min(possible * rows / (rows - 1), frame_duration) : Duration(0);
}

class LibcameraCamera : public Camera, private BufferLease::Owner {
 public:
  LibcameraCamera(std::shared_ptr<lc::CameraManager> manager, std::shared_ptr<lc::Camera> camera)
      : manager_(std::move(manager)),
        camera_(std::move(camera)),
        capabilities_(capabilities_of(*camera_)),
        paced_(capabilities_.sets_exposure && !has_algorithms(*camera_)) {
    camera_->requestCompleted.connect(this, &LibcameraCamera::on_completed);
    camera_->disconnected.connect(this, &LibcameraCamera::on_disconnected);
  }
  ~LibcameraCamera() override {
    (void)LibcameraCamera::stop();
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
    requests_.clear(), buffers_.reset();
    camera_->release();
  }

  const CameraCapabilities& capabilities() const override { return capabilities_; }

  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override {
    const std::lock_guard lock(mutex_);
    TRY(check_configurable(wanted, buffers));
    slots_.reset(0), requests_.clear(), buffers_.reset();
    auto configuration = camera_->generateConfiguration(
        {is_raw(wanted.format) ? lc::StreamRole::Raw : lc::StreamRole::Viewfinder});
    if (configuration == nullptr || configuration->empty()) return does_not_offer(wanted.format);
    lc::StreamConfiguration& stream = configuration->at(0);
    stream.pixelFormat = libcamera_format_of(wanted.format);
    stream.size = {static_cast<unsigned>(wanted.width), static_cast<unsigned>(wanted.height)};
    stream.bufferCount = static_cast<unsigned>(buffers);
    if (configuration->validate() == lc::CameraConfiguration::Invalid) return does_not_offer(wanted.format);
    const auto taken = format_of(stream.pixelFormat);
    if (!taken || !stands_for(*taken, wanted.format)) return does_not_offer(wanted.format);
    if (const int code = camera_->configure(configuration.get()); code != 0)
      return libcamera_error(code, capabilities_.id, "take the picture format");
    describe_exposure(*camera_, capabilities_);  // the Raspberry Pi's limits are those of the sensor's mode
    mode_ = wanted;
    mode_.format = *taken;
    mode_.width = static_cast<int>(stream.size.width), mode_.height = static_cast<int>(stream.size.height);
    mode_.frame_duration = constant_frame_duration(wanted.frame_duration);
    yuv_ = stream.colorSpace ? coding_of(*stream.colorSpace) : YuvCoding();
    stride_ = mode_.format == PixelFormat::Mjpeg ? 0 : stream.stride;
    buffers_ = TRY(LibcameraBuffers::allocate(camera_, *stream.stream(), buffers));
    TRY(make_requests(*stream.stream()));
    slots_.reset(requests_.size());
    capabilities_.buffers = static_cast<int>(requests_.size());
    return mode_;
  }

  Result<void> start() override {
    const std::lock_guard lock(mutex_);
    if (started_) return already_started(capabilities_.id);
    if (slots_.empty()) return not_configured(capabilities_.id);
    slots_.free_queued();
    {
      const std::lock_guard completions(completions_mutex_);
      if (gone_) return libcamera_error(-ENODEV, capabilities_.id, "start");
      first_ = count_ = 0;
      pacer_.restart(), frames_.restart();
      for (Request& request : requests_) request.turn.reset();
    }
    lc::ControlList controls(camera_->controls());
    take_over(controls);
    if (const int code = camera_->start(&controls); code != 0)
      return libcamera_error(code, capabilities_.id, "start its stream");
    first_request_ = true;
    const std::lock_guard completions(completions_mutex_);
    started_ = true;
    return {};
  }

  Result<void> queue(const ExposureRequest& wanted) override {
    const std::lock_guard lock(mutex_);
    if (!started_) return not_started(capabilities_.id);
    TRY(check_exposure(capabilities_, wanted));
    const std::size_t slot = TRY(slots_.free_one());
    lc::Request& request = *requests_[slot].own;
    request.reuse(lc::Request::ReuseBuffers);
    if (std::exchange(first_request_, false)) take_over(request.controls());
    const auto turn = set_exposure(requests_[slot], wanted);
    slots_.queue(slot, wanted.cookie);
    if (const int code = camera_->queueRequest(&request); code != 0) {
      slots_.free(slot);
      return libcamera_error(unplugged() ? -ENODEV : code, capabilities_.id, "queue a request");
    }
    if (turn) {
      const std::lock_guard completions(completions_mutex_);
      pacer_.written(*turn, posix_clock().now());
    }
    return {};
  }

  Result<CapturedBuffer> wait(Duration timeout) override {
    std::size_t index = 0;
    {
      std::unique_lock completions(completions_mutex_);
      changed_.wait_for(completions, timeout, [&] { return count_ > 0 || gone_ || !started_; });
      if (!started_) return stopped(capabilities_.id);
      if (count_ == 0 && gone_) return libcamera_error(-ENODEV, capabilities_.id, "deliver a frame");
      if (count_ == 0) return no_frame_within(capabilities_.id, timeout);
      index = completed_[first_];
      first_ = (first_ + 1) % completed_.size(), --count_;
    }
    const std::lock_guard lock(mutex_);
    return delivered(index);
  }

  Result<void> stop() override {
    const std::lock_guard lock(mutex_);
    if (!started_) return {};
    {
      const std::lock_guard completions(completions_mutex_);
      started_ = false;
    }
    changed_.notify_all();
    const int code = camera_->stop();  // completes every queued request as cancelled
    if (code != 0 && !unplugged()) return libcamera_error(code, capabilities_.id, "stop its stream");
    return {};
  }

 private:
  // Of the buffer of the same index.
  struct Request {
    std::unique_ptr<lc::Request> own;
    // Written by libcamera's thread before it reports the completion.
    bool control_late = false;
    bool cancelled = false;  // while the stream ran
    CompletedFrames::Place place;
    std::optional<ControlPacer::Turn> turn;  // at the controls, that it carries; under completions_mutex_
  };

  void give_back(int index) override {
    const std::lock_guard lock(mutex_);
    slots_.free(static_cast<std::size_t>(index));
  }

  Result<void> check_configurable(const StreamMode& wanted, int buffers) const {
    if (started_) return must_stop_to_configure(capabilities_.id);
    TRY(check_buffers(buffers, ControlPacer::kDepth));
    TRY(check_size(wanted));
    return slots_.check_none_leased();
  }

  // libcamera makes none of a camera that was unplugged meanwhile.
  Result<void> make_requests(lc::Stream& stream) {
    requests_.resize(buffers_->size());
    for (std::size_t i = 0; i < requests_.size(); ++i) {
      requests_[i].own = camera_->createRequest(i);
      if (requests_[i].own == nullptr || requests_[i].own->addBuffer(&stream, &buffers_->buffer(i)) != 0)
        return libcamera_error(-ENODEV, capabilities_.id, "make its requests");
    }
    return {};
  }

  Error does_not_offer(PixelFormat format) const {
    std::string list;
    const char* last = "";
    for (const StreamMode& mode : capabilities_.modes)
      if (std::strcmp(last, name(mode.format)) != 0)
        list += (list.empty() ? "" : ", ") + std::string(last = name(mode.format));
    return {ErrorCode::Unsupported,
            fmt::format("camera '{}' does not offer {}; it offers {}", capabilities_.id, name(format),
                        list.empty() ? "none that hdrcam knows" : list)};
  }

  Duration constant_frame_duration(Duration wanted) const {
    if (!has_algorithms(*camera_)) return kUsualFrameDuration;
    const auto& limits = camera_->controls().at(lc::controls::FrameDurationLimits.id());
    return std::clamp<Duration>(wanted, microseconds(limits.min().get<std::int64_t>()),
                                microseconds(limits.max().get<std::int64_t>()));
  }

  // Its position 1 is the device's default; where that is the highest too, libcamera divides by zero.
  bool has_gain_slider() const {
    return paced_ && offers(*camera_, lc::controls::AnalogueGain) &&
           camera_->controls().at(lc::controls::AnalogueGain.id()).max().get<float>() > 1;
  }

  // Switches automatic controls off and fixes the frame duration: at the start of the stream, or (in
  // pipelines that ignore that) with the first frame.
  void take_over(lc::ControlList& controls) const {
    if (offers(*camera_, lc::controls::AeEnable)) controls.set(lc::controls::AeEnable, false);
    if (offers(*camera_, lc::controls::AwbEnable)) controls.set(lc::controls::AwbEnable, false);
    if (has_gain_slider()) controls.set(lc::controls::AnalogueGain, 1.F);
    if (!has_algorithms(*camera_)) return;
    const std::int64_t duration_us = std::chrono::duration_cast<microseconds>(mode_.frame_duration).count();
    const std::array limits{duration_us, duration_us};
    controls.set(lc::controls::FrameDurationLimits, lc::Span<const std::int64_t, 2>(limits));
  }

  // The controls of the request: its own exposure, or (paced) the exposure of the next frame.
  std::optional<ControlPacer::Turn> set_exposure(Request& request, const ExposureRequest& wanted) {
    lc::ControlList& controls = request.own->controls();
    std::optional<ControlPacer::Turn> turn;
    if (!capabilities_.sets_exposure) return turn;
    if (paced_) {
      const std::lock_guard completions(completions_mutex_);
      pacer_.queued(wanted);
      turn = request.turn = pacer_.next();
    }
    const ExposureRequest& now = turn ? turn->request : wanted;
    controls.set(lc::controls::ExposureTime,
                 static_cast<std::int32_t>(std::chrono::duration_cast<microseconds>(now.exposure).count()));
    if (!paced_ && offers(*camera_, lc::controls::AnalogueGain))
      controls.set(lc::controls::AnalogueGain, static_cast<float>(now.analogue_gain));
    return turn;
  }

  Instant timestamp_of(lc::Request& request, const lc::FrameMetadata& frame) const {
    const std::int64_t stamp_ns = request.metadata()
                                      .get(lc::controls::SensorTimestamp)
                                      .value_or(static_cast<std::int64_t>(frame.timestamp));
    return instant_of_recent_stamp(posix_clock(), Duration(stamp_ns));
  }

  CapturedBuffer delivered(std::size_t index) {
    const Request& request = requests_[index];
    const lc::FrameMetadata& frame = buffers_->buffer(index).metadata();
    const lc::ControlList& metadata = request.own->metadata();
    CapturedBuffer buffer;
    buffer.cookie = slots_.lease(index);
    buffer.lease = BufferLease(*this, static_cast<int>(index));
    buffer.sequence = request.place.sequence;
    buffer.timestamp = request.place.timestamp;
    buffer.control_late = request.control_late;
    buffer.damaged = request.cancelled || frame.status != lc::FrameMetadata::FrameSuccess;
    if (const auto exposure_us = metadata.get(lc::controls::ExposureTime))
      buffer.exposure = microseconds(*exposure_us);
    if (const auto gain = metadata.get(lc::controls::AnalogueGain)) buffer.analogue_gain = *gain;
    if (const auto gain = metadata.get(lc::controls::DigitalGain)) buffer.digital_gain = *gain;
    if (const auto skew_ns = metadata.get(lc::controls::draft::SensorRollingShutterSkew))
      buffer.readout = readout_of(Duration(*skew_ns), mode_.height, mode_.frame_duration);
    if (const auto levels = metadata.get(lc::controls::SensorBlackLevels); levels && is_raw(mode_.format))
      buffer.black_level = black_level_of(std::span<const std::int32_t, 4>(levels->data(), levels->size()),
                                          packed_format(mode_.format)->bits);
    buffer.mode = mode_, buffer.yuv = yuv_, buffer.stride = stride_;
    buffer.pixels = buffers_->memory(index);
    if (stride_ == 0 && !frame.planes().empty())
      buffer.pixels =
          buffer.pixels.first(std::min<std::size_t>(buffer.pixels.size(), frame.planes()[0].bytesused));
    buffer.dmabuf_fd = buffers_->buffer(index).planes()[0].fd.get();
    return buffer;
  }

  // Both are called by libcamera's own thread. A request that the pipeline cancels while the stream runs
  // comes as a damaged frame, so that its buffer and its turn at the controls do not get lost.
  void on_completed(lc::Request* request) {
    const auto index = static_cast<std::size_t>(request->cookie());
    const bool cancelled = request->status() == lc::Request::RequestCancelled;
    const lc::FrameMetadata& frame = buffers_->buffer(index).metadata();
    const Instant timestamp = cancelled ? posix_clock().now() : timestamp_of(*request, frame);
    {
      const std::lock_guard completions(completions_mutex_);
      if (cancelled && !started_) return;  // by stop()
      Request& own = requests_[index];
      own.cancelled = cancelled;
      own.place = cancelled ? frames_.cancelled(timestamp, mode_.frame_duration)
                            : frames_.completed(frame.sequence, timestamp);
      completed_[(first_ + count_++) % completed_.size()] = index;
      if (paced_) own.control_late = completed_late(own.place.timestamp);
    }
    changed_.notify_one();
  }
  // libcamera cancels a request whose controls the device refused, and completes it in its turn: later than
  // the frame that they were for. Until that frame nobody uses a request again that carries its controls.
  bool completed_late(Instant timestamp) {
    const auto turn = pacer_.next();
    for (const Request& request : requests_)
      if (turn && request.turn && request.turn->index == turn->index &&
          request.own->status() == lc::Request::RequestCancelled)
        pacer_.given_up(*turn);
    return pacer_.completed(timestamp);
  }
  void on_disconnected() {
    {
      const std::lock_guard completions(completions_mutex_);
      gone_ = true;
    }
    changed_.notify_all();
  }
  bool unplugged() {
    const std::lock_guard completions(completions_mutex_);
    return gone_;
  }

  std::shared_ptr<lc::CameraManager> manager_;
  std::shared_ptr<lc::Camera> camera_;
  CameraCapabilities capabilities_;
  bool paced_;  // exposures are written when queued, see ControlPacer
  StreamMode mode_;
  YuvCoding yuv_;
  std::size_t stride_ = 0;
  std::unique_ptr<LibcameraBuffers> buffers_;

  std::mutex mutex_;  // of slots, requests and calls into the camera, against stop() and leases given back
  BufferSlots slots_{capabilities_.id};
  std::vector<Request> requests_;
  bool first_request_ = false;

  // Guards what libcamera's thread writes; taken inside mutex_, never around it.
  std::mutex completions_mutex_;
  std::condition_variable changed_;
  bool started_ = false;  // written under both
  bool gone_ = false;
  std::array<std::size_t, ControlPacer::kDepth> completed_{};  // slots, a ring
  std::size_t first_ = 0, count_ = 0;
  CompletedFrames frames_;
  ControlPacer pacer_;
};

// The camera with this name, or the only one whose id or model contains it.
Result<std::shared_ptr<lc::Camera>> find_camera(const lc::CameraManager& manager, const std::string& wanted) {
  std::vector<std::shared_ptr<lc::Camera>> matches;
  std::string all;
  for (const auto& camera : manager.cameras()) {
    if (camera->id() == wanted) return camera;
    const std::string model = camera->properties().get(lc::properties::Model).value_or("");
    if (camera->id().find(wanted) != std::string::npos || model.find(wanted) != std::string::npos)
      matches.push_back(camera);
    all += fmt::format("{}'{}'", all.empty() ? "" : ", ", camera->id());
  }
  if (matches.size() == 1) return matches.front();
  if (matches.size() > 1)
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' matches {} cameras; use a whole id: {}", wanted, matches.size(), all)};
  return Error{ErrorCode::NotFound,
               fmt::format("libcamera has no camera '{}'; it has {}", wanted, all.empty() ? "none" : all)};
}

}  // namespace

void show_libcamera_log() { log_shown = true; }

Result<std::vector<CameraCapabilities>> list_libcamera_cameras() {
  const auto manager = TRY(camera_manager());
  std::vector<CameraCapabilities> list;
  for (const auto& camera : manager->cameras()) list.push_back(capabilities_of(*camera));
  return list;
}

Result<std::unique_ptr<Camera>> open_libcamera_camera(const std::string& id) {
  auto manager = TRY(camera_manager());
  auto camera = TRY(find_camera(*manager, id));
  if (const int code = camera->acquire(); code != 0) return libcamera_error(code, camera->id(), "open it");
  return std::unique_ptr<Camera>(std::make_unique<LibcameraCamera>(std::move(manager), std::move(camera)));
}

}  // namespace hdrcam

#endif
