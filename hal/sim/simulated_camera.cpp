#include "hal/sim/simulated_camera.h"

#include <algorithm>
#include <thread>

#include "hal/pixel_pack.h"
#include "hal/sim/injected_faults.h"

namespace hdrcam {
namespace {

constexpr Duration kShortestFrame = std::chrono::milliseconds(1);
constexpr Duration kExposureStep = std::chrono::microseconds(10);
// Until a control acts, if frames are long enough.
constexpr Duration kFirstExposure = std::chrono::milliseconds(4);
constexpr PixelFormat kFormats[] = {PixelFormat::Rgb24,        PixelFormat::Bgr24,       PixelFormat::Rggb8,
                                    PixelFormat::Rggb10,       PixelFormat::Rggb12,      PixelFormat::Rggb16,
                                    PixelFormat::Rggb10Packed, PixelFormat::Rggb12Packed};

// The part of a frame in which nothing is exposed.
Duration readout_of(Duration frame) { return std::min<Duration>(std::chrono::milliseconds(1), frame / 8); }

ControlDelays delays_of(const Simulation& s) {
  return s.plan.on(Effect::ControlDelay) ? s.control_delay : ControlDelays{};
}

CameraCapabilities capabilities_of(const Simulation& s) {
  CameraCapabilities can;
  const char* scene = scene_catalog()[static_cast<std::size_t>(s.scene.scene)].name;
  can.id = fmt::format("sim:{}", scene);
  can.model = "simulated sensor";
  can.driver = "sim";
  for (const PixelFormat format : kFormats) can.modes.push_back({format, s.width, s.height, kShortestFrame});
  can.usual_frame_duration = s.frame_duration();
  can.exposure_min = kExposureStep, can.exposure_step = kExposureStep;
  can.exposure_max = s.frame_duration() - readout_of(s.frame_duration());
  can.gain_min = 1, can.gain_max = 16;
  can.sets_exposure = true;
  can.reports_exposure = s.reports_exposure;
  can.exposure_per_request = !s.plan.on(Effect::ControlDelay);
  if (s.reports_exposure) can.delays = delays_of(s);  // an unknown sensor reports neither
  return can;
}

Error not_started(const char* what) {
  return {ErrorCode::Invalid, fmt::format("the simulated camera is not started; start it before {}", what)};
}
Error unplugged() { return {ErrorCode::Unplugged, "the simulated camera was unplugged"}; }

// The nearest size that can be rendered and packed.
int near_size(int wanted, int otherwise, int multiple) {
  const int size = wanted > 0 ? std::clamp(wanted, kLeastSimulated_px, kMostSimulated_px) : otherwise;
  return size / multiple * multiple;
}

}  // namespace

SimulatedCamera::SimulatedCamera(const Simulation& simulation, SimTime time, int threads,
                                 const SimulatedWiring& wiring)
    : simulation_(simulation),
      stream_(simulation),
      time_(time),
      wiring_(wiring),
      pool_(threads),
      capabilities_(capabilities_of(simulation)),
      exposure_(delays_of(simulation).exposure, kFirstExposure),
      gain_(delays_of(simulation).gain, 1),
      faults_(std::make_unique<InjectedFaults>()) {
  if (triggered()) wiring_.trigger->listen([this](const Edge& edge) { trigger(edge); });
}

SimulatedCamera::~SimulatedCamera() {
  if (triggered()) wiring_.trigger->listen({});
}

Result<StreamMode> SimulatedCamera::configure(const StreamMode& wanted, int buffers) {
  {
    const std::lock_guard lock(mutex_);
    if (started_)
      return Error{ErrorCode::Invalid, "the simulated camera is started; stop it before configuring it"};
    if (free_.size() < buffers_.size())
      return Error{ErrorCode::Busy,
                   "a frame of the simulated camera is still being read; give it back before configuring it"};
  }
  if (std::find(std::begin(kFormats), std::end(kFormats), wanted.format) == std::end(kFormats))
    return Error{ErrorCode::Unsupported,
                 fmt::format("the simulated camera has no {}; ask for RGB24, BGR24 or a RGGB format",
                             name(wanted.format))};
  if (buffers < 1)
    return Error{ErrorCode::Invalid,
                 fmt::format("{} buffers cannot hold a frame; ask for 1 or more", buffers)};
  const PackedFormat packed = packed_format(wanted.format).value();
  const int multiple = packed.layout == PixelLayout::Rgb ? 1 : std::max(2, packed.multiple);
  simulation_.width = near_size(wanted.width, simulation_.width, multiple);
  simulation_.height =
      near_size(wanted.height, simulation_.height, packed.layout == PixelLayout::Rgb ? 1 : 2);
  if (wanted.frame_duration > Duration::zero())
    simulation_.framerate_hz = 1 / to_seconds(std::max(wanted.frame_duration, kShortestFrame));
  mode_ = {wanted.format, simulation_.width, simulation_.height, simulation_.frame_duration()};
  capabilities_ = capabilities_of(simulation_);
  if (packed.layout != PixelLayout::Rgb && simulation_.reports_exposure)
    capabilities_.black_level = BlackLevel(255 * static_cast<double>(simulation_.black_level));
  sensor_ = std::make_unique<SimulatedSensor>(simulation_, packed.layout, packed.bits, pool_);
  const std::size_t bytes = packed_stride(mode_.format, mode_.width) * static_cast<std::size_t>(mode_.height);
  const auto count = static_cast<std::size_t>(buffers);
  buffers_.assign(count, std::vector<std::byte>(bytes));
  free_.reset(count), requests_.reset(count), frames_.reset(count);
  for (int i = 0; i < buffers; ++i) free_.push(i);
  return mode_;
}

Result<void> SimulatedCamera::start() {
  const std::lock_guard lock(mutex_);
  if (started_) return Error{ErrorCode::Invalid, "the simulated camera is started already"};
  if (!sensor_)
    return Error{ErrorCode::Invalid,
                 "the simulated camera is not configured; configure it before starting it"};
  if (faults_->unplugged) return unplugged();
  started_ = true;
  const Instant now = time_.now();
  epoch_ = triggered() ? now : now + mode_.frame_duration;  // the sensor starts up
  opened_.reset(), read_out_ = now;
  next_frame_ = 0;
  exposure_ = DelayedControl<Duration>(delays_of(simulation_).exposure,
                                       std::min(kFirstExposure, capabilities_.exposure_max));
  gain_ = DelayedControl<double>(delays_of(simulation_).gain, 1);
  return {};
}

Result<void> SimulatedCamera::queue(const ExposureRequest& request) {
  const std::lock_guard lock(mutex_);
  if (!started_) return not_started("queueing requests");
  if (faults_->unplugged) return unplugged();
  TRY(check_exposure(capabilities_, request));
  advance(time_.now());
  if (free_.empty())
    return Error{ErrorCode::Busy,
                 fmt::format("all {} buffers of the simulated camera are queued or in use; give one back",
                             buffers_.size())};
  requests_.push({request, free_.pop()});
  changed_.notify_all();
  return {};
}

Result<CapturedBuffer> SimulatedCamera::wait(Duration timeout) {
  std::unique_lock lock(mutex_);
  const Instant deadline = time_.now() + timeout;
  for (;;) {
    if (!started_) return Error{ErrorCode::Interrupted, "the simulated camera was stopped"};
    if (faults_->unplugged) return unplugged();
    const Instant now = time_.now();
    advance(now);
    if (!frames_.empty() && frames_.front().ready <= now) break;
    if (now >= deadline)
      return Error{ErrorCode::Timeout,
                   fmt::format("no frame came within {:.0f} ms", to_seconds(timeout) * 1e3)};
    const Instant next = !frames_.empty() ? frames_.front().ready
                         : triggered()    ? deadline
                                          : begin_of(next_frame_);
    time_.wait(lock, changed_, std::min(next, deadline));
  }
  const Frame frame = frames_.pop();
  lock.unlock();
  return develop(frame);
}

Result<void> SimulatedCamera::stop() {
  {
    const std::lock_guard lock(mutex_);
    started_ = false;
    while (!requests_.empty()) free_.push(requests_.pop().buffer);
    while (!frames_.empty()) free_.push(frames_.pop().buffer);
  }
  changed_.notify_all();
  return {};
}

void SimulatedCamera::give_back(int buffer) {
  const std::lock_guard lock(mutex_);
  free_.push(buffer);
}

Instant SimulatedCamera::begin_of(std::uint64_t frame) const {
  return epoch_ + stream_.host_time(mode_.frame_duration * static_cast<Duration::rep>(frame));
}

// Starts every frame that is due.
void SimulatedCamera::advance(Instant now) {
  while (started_ && !triggered() && begin_of(next_frame_) <= now) {
    begin_frame(next_frame_, begin_of(next_frame_), std::nullopt);
    ++next_frame_;
  }
}

// An edge of the trigger line.
void SimulatedCamera::trigger(const Edge& edge) {
  {
    const std::lock_guard lock(mutex_);
    if (!started_) return;
    if (edge.rising) {
      if (edge.at < read_out_) return;
      opened_ = edge.at;
      if (wiring_.mode == TriggerMode::PulseWidth) return;
    }
    if (!opened_) return;
    const Instant begin = *opened_;
    opened_.reset();
    begin_frame(next_frame_++, begin,
                edge.rising ? std::optional<Duration>() : std::optional(edge.at - begin));
  }
  changed_.notify_all();
}

// When the next pulse may open a frame, or the next frame opens by itself.
Instant SimulatedCamera::end_of(const Frame& frame) const {
  return triggered() ? frame.begin + frame.exposure + readout_of(mode_.frame_duration)
                     : begin_of(frame.sequence + 1);
}

// pulse: the exposure of a frame whose trigger pulse set it.
void SimulatedCamera::begin_frame(std::uint64_t sequence, Instant begin, std::optional<Duration> pulse) {
  const bool delivered = !is_lost(sequence) && !requests_.empty();
  if (!requests_.empty()) write_controls(sequence, requests_.front().asked);
  Request request;
  if (delivered) request = requests_.pop();
  Frame frame;
  frame.sequence = sequence;
  frame.exposure = exposure_.latch(sequence), frame.gain = gain_.latch(sequence);
  if (pulse) frame.exposure = *pulse;
  frame.begin = begin;
  frame.stamp = frame.begin + stream_.latency(sequence);
  read_out_ = end_of(frame);
  // The last rows of a rolling shutter are exposed while the next frame's first ones are.
  frame.ready = std::max(read_out_, frame.begin + frame.exposure + simulation_.readout());
  faults_->history[sequence % InjectedFaults::kHistory] = {sequence, frame.exposure, frame.gain, frame.begin};
  if (wiring_.strobe != nullptr) wiring_.strobe->strobe(frame.begin, frame.exposure);
  if (!delivered) return;
  frame.buffer = request.buffer;
  tell(frame, request.asked.cookie);
  frames_.push(frame);
}

bool SimulatedCamera::is_lost(std::uint64_t frame) {
  if (faults_->drops > 0) return --faults_->drops, true;
  return stream_.loses(frame);
}

void SimulatedCamera::write_controls(std::uint64_t frame, const ExposureRequest& asked) {
  const ControlFault fault = faults_->disturbed_requests > 0 ? faults_->control : ControlFault::None;
  if (faults_->disturbed_requests > 0) --faults_->disturbed_requests;
  if (fault == ControlFault::Ignored) return;
  const Duration steps = asked.exposure / kExposureStep * kExposureStep;
  const bool clipped = fault == ControlFault::Clipped;
  const int late = fault == ControlFault::Early ? -1 : fault == ControlFault::Late ? 1 : 0;
  exposure_.write(frame, clipped ? std::min(steps, InjectedFaults::kClippedExposure) : steps, late);
  gain_.write(frame, clipped ? 1 : asked.analogue_gain, late);
}

// Fills in the facts that the buffer will report.
void SimulatedCamera::tell(Frame& frame, std::uint64_t cookie) {
  const Report truth{cookie, frame.exposure, frame.gain};
  const MetadataFault fault = faults_->disturbed_buffers > 0 ? faults_->metadata : MetadataFault::None;
  if (faults_->disturbed_buffers > 0) --faults_->disturbed_buffers;
  frame.report = truth;
  frame.reported = simulation_.reports_exposure && fault != MetadataFault::Missing;
  if (fault == MetadataFault::Late)
    frame.report.exposure = last_report_.exposure, frame.report.gain = last_report_.gain;
  if (fault == MetadataFault::Doubled) frame.report = last_report_;
  last_report_ = truth;
}

CapturedBuffer SimulatedCamera::develop(const Frame& frame) {
  const double begin_s = triggered() ? to_seconds(frame.begin - epoch_)
                                     : to_seconds(mode_.frame_duration) * static_cast<double>(frame.sequence);
  sensor_->expose({frame.sequence, begin_s, to_seconds(frame.exposure), frame.gain}, codes_);
  std::vector<std::byte>& bytes = buffers_[static_cast<std::size_t>(frame.buffer)];
  pack_codes(codes_, mode_.format, bytes);
  CapturedBuffer buffer;
  buffer.cookie = frame.report.cookie;
  buffer.sequence = frame.sequence;
  buffer.timestamp = frame.stamp;
  buffer.readout = simulation_.readout();
  if (frame.reported) {
    buffer.exposure = frame.report.exposure, buffer.analogue_gain = frame.report.gain,
    buffer.digital_gain = 1;
    buffer.exposure_source = ExposureSource::Embedded;
  }
  buffer.mode = mode_;
  buffer.stride = packed_stride(mode_.format, mode_.width);
  buffer.pixels = bytes;
  buffer.lease = BufferLease(*this, frame.buffer);
  return buffer;
}

Result<std::unique_ptr<Camera>> open_simulated_camera(std::string_view scene, const SimulatedWiring& wiring) {
  const Simulation simulation = TRY(simulation_of(scene));
  const int threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 4u));
  return std::unique_ptr<Camera>(std::make_unique<SimulatedCamera>(simulation, SimTime(), threads, wiring));
}

}  // namespace hdrcam
