#include "hal/replay/replayed_camera.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "hal/core/counted.h"
#include "hal/pixel_pack.h"
#include "hal/recording/exposure_cycle.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

Instant stamp_of(const FrameFacts& facts, TimestampMark mark) {
  if (!facts.has_exposure() || !facts.has_exposure_time()) return facts.timestamp;
  const double half_s = (facts.exposure_s + facts.readout_s) / 2;
  return facts.timestamp + from_seconds(mark == TimestampMark::ExposureEnd ? half_s : -half_s);
}

// Of exposures that differ either the begins or the ends are evenly spaced: what counts frames by their time
// (capture/) needs those.
TimestampMark mark_of(const std::vector<FrameFacts>& frames) {
  constexpr double kClearly = 2;
  if (frames.size() < 2 || frames.back().sequence <= frames.front().sequence)
    return TimestampMark::ExposureBegin;
  const auto numbers = [](const FrameFacts& from, const FrameFacts& to) {
    return static_cast<double>(to.sequence) - static_cast<double>(from.sequence);
  };
  const double frame_s =
      to_seconds(frames.back().timestamp - frames.front().timestamp) / numbers(frames.front(), frames.back());
  const auto unevenness = [&](TimestampMark mark) {
    double sum_s = 0;
    for (std::size_t i = 1; i < frames.size(); ++i)
      sum_s += std::abs(to_seconds(stamp_of(frames[i], mark) - stamp_of(frames[i - 1], mark)) -
                        frame_s * numbers(frames[i - 1], frames[i]));
    return sum_s;
  };
  return kClearly * unevenness(TimestampMark::ExposureEnd) < unevenness(TimestampMark::ExposureBegin)
             ? TimestampMark::ExposureEnd
             : TimestampMark::ExposureBegin;
}

// What a camera's capabilities state and a recording states with its frames, of the first ones that are
// whole.
Result<std::vector<FrameFacts>> first_facts(RecordingReader& reader, const std::string& path) {
  constexpr std::size_t kFrames = 24;
  std::vector<FrameFacts> frames;
  while (frames.size() < kFrames) {
    auto facts = reader.next_facts();
    if (!facts && facts.error().code == ErrorCode::Truncated && !frames.empty()) break;
    if (!facts) return facts.error();
    if (!facts.value()) break;
    frames.push_back(**facts);
  }
  if (frames.empty() && reader.left_out().count > 0) return no_whole_frame(path);
  return frames;
}

// The cycle of exposures; empty where nothing repeats.
std::vector<ExposureRequest> recorded_cycle(const std::vector<FrameFacts>& frames) {
  const ExposureCycle found = find_exposure_cycle(frames);
  std::vector<ExposureRequest> cycle(static_cast<std::size_t>(found.period));
  for (const FrameFacts& frame : frames)
    if (const int slot = slot_of(found, frames.front(), frame); slot >= 0 && frame.has_exposure())
      cycle[static_cast<std::size_t>(slot)] = {0, from_seconds(frame.exposure_s), frame.gain()};
  return cycle;
}

class ReplayedCamera : public Camera, private BufferLease::Owner {
 public:
  ReplayedCamera(Storage& storage, std::string path, const CameraFacts& facts, PixelFormat format,
                 const std::vector<FrameFacts>& first, ReplayPace pace, Clock& clock)
      : storage_(storage), path_(std::move(path)), pace_(pace), clock_(clock) {
    mode_ = {format, facts.width, facts.height,
             Duration(static_cast<Duration::rep>(1e9 / facts.framerate_hz + 0.5))};
    capabilities_.id = "replay:" + path_;
    capabilities_.model = facts.name;
    capabilities_.driver = "replay";
    capabilities_.modes = {mode_};
    capabilities_.usual_frame_duration = mode_.frame_duration;
    capabilities_.reports_exposure = true;
    capabilities_.cycle = recorded_cycle(first);
    capabilities_.timestamp_mark = mark_of(first);
    capabilities_.recorded = facts;
    for (const FrameFacts& frame : first)
      if (!capabilities_.black_level) capabilities_.black_level = frame.black_level;
  }

  const CameraCapabilities& capabilities() const override { return capabilities_; }

  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override {
    const std::lock_guard lock(mutex_);
    if (started_)
      return Error{ErrorCode::Invalid,
                   fmt::format("'{}' is being replayed; stop it before configuring it", path_)};
    if (std::ranges::find(in_use_, true) != in_use_.end())
      return Error{
          ErrorCode::Busy,
          fmt::format("a frame of '{}' is still being read; give it back before configuring it", path_)};
    if (wanted.format != mode_.format)
      return Error{ErrorCode::Unsupported, fmt::format("'{}' was recorded as {} and cannot be replayed as {}",
                                                       path_, name(mode_.format), name(wanted.format))};
    if (buffers < 1)
      return Error{ErrorCode::Invalid,
                   fmt::format("{} buffers cannot hold a frame; ask for 1 or more", buffers)};
    const std::size_t bytes =
        packed_stride(mode_.format, mode_.width) * static_cast<std::size_t>(mode_.height);
    buffers_.assign(static_cast<std::size_t>(buffers), std::vector<std::byte>(bytes));
    in_use_.assign(buffers_.size(), false);
    cookies_.assign(buffers_.size(), 0);
    first_cookie_ = queued_ = 0;
    return mode_;
  }

  // From the first frame again.
  Result<void> start() override {
    const std::lock_guard lock(mutex_);
    if (started_) return Error{ErrorCode::Invalid, fmt::format("'{}' is being replayed already", path_)};
    if (buffers_.empty())
      return Error{ErrorCode::Invalid, fmt::format("configure '{}' before starting it", path_)};
    reader_ = TRY(open_recording(storage_, path_, Damage::IsSkipped));
    next_.reset();
    delivered_ = 0;
    due_ = clock_.now();
    started_ = true;
    return {};
  }

  Result<void> queue(const ExposureRequest& request) override {
    const std::lock_guard lock(mutex_);
    if (!started_)
      return Error{ErrorCode::Invalid, fmt::format("start '{}' before queueing requests", path_)};
    const auto used = static_cast<std::size_t>(std::count(in_use_.begin(), in_use_.end(), true));
    if (used + queued_ >= buffers_.size())
      return Error{ErrorCode::Busy, fmt::format("all {} buffers of '{}' are queued or in use; give one back",
                                                buffers_.size(), path_)};
    cookies_[(first_cookie_ + queued_++) % cookies_.size()] = request.cookie;
    changed_.notify_all();
    return {};
  }

  Result<CapturedBuffer> wait(Duration timeout) override {
    std::unique_lock lock(mutex_);
    const Instant deadline = clock_.now() + timeout;
    for (;;) {
      if (!started_)
        return Error{ErrorCode::Interrupted, fmt::format("the replay of '{}' was stopped", path_)};
      if (queued_ > 0) {
        TRY(read_ahead());
        if (due_ <= clock_.now()) return deliver();
      }
      const Instant now = clock_.now();
      if (now >= deadline)
        return Error{ErrorCode::Timeout,
                     fmt::format("no frame was due within {:.0f} ms", to_seconds(timeout) * 1e3)};
      const Instant until = queued_ > 0 ? std::min(due_, deadline) : deadline;
      changed_.wait_for(lock, until - now);
    }
  }

  Result<void> stop() override {
    {
      const std::lock_guard lock(mutex_);
      started_ = false;
      queued_ = 0;
    }
    changed_.notify_all();
    return {};
  }

  std::vector<std::string> warnings() const override {
    const std::lock_guard lock(mutex_);
    return reader_ ? warnings_of(*reader_) : std::vector<std::string>();
  }

 private:
  void give_back(int index) override {
    const std::lock_guard lock(mutex_);
    in_use_[static_cast<std::size_t>(index)] = false;
  }

  Result<void> read_ahead() {
    if (next_) return {};
    next_ = TRY(reader_->next(std::move(room_)));
    if (!next_)
      return Error{ErrorCode::Unplugged,
                   fmt::format("the recording '{}' ended after {}", path_, counted(delivered_, "frame"))};
    const Instant at = next_->facts.timestamp;
    if (pace_ == ReplayPace::AsRecorded && delivered_ > 0)
      due_ = due_ + std::min(at - last_, longest_pause());
    last_ = at;
    return {};
  }

  // Whoever waits for a camera gives up after some frames without one: a longer pause is cut.
  Duration longest_pause() const {
    constexpr Duration kLeast = std::chrono::seconds(1);
    constexpr int kFrames = 5;
    return std::max(kLeast, kFrames * mode_.frame_duration);
  }

  CapturedBuffer deliver() {
    const auto free = std::find(in_use_.begin(), in_use_.end(), false) - in_use_.begin();
    std::vector<std::byte>& bytes = buffers_[static_cast<std::size_t>(free)];
    in_use_[static_cast<std::size_t>(free)] = true;
    pack_codes(next_->codes, mode_.format, bytes);
    const FrameFacts& facts = next_->facts;
    CapturedBuffer buffer;
    buffer.cookie = cookies_[first_cookie_];
    first_cookie_ = (first_cookie_ + 1) % cookies_.size();
    --queued_, ++delivered_;
    buffer.sequence = facts.sequence;
    buffer.timestamp = stamp_of(facts, capabilities_.timestamp_mark);
    buffer.centre = facts.timestamp;
    buffer.damaged = (facts.flags & kFrameDamaged) != 0;
    if (facts.exposure_source != ExposureSource::Unknown && facts.has_exposure()) {
      buffer.exposure = from_seconds(facts.exposure_s);
      buffer.analogue_gain = facts.analogue_gain, buffer.digital_gain = facts.digital_gain;
    }
    buffer.readout = from_seconds(facts.readout_s);
    buffer.black_level = facts.black_level;
    buffer.exposure_source = facts.exposure_source;
    buffer.T_world_camera = facts.T_world_camera;
    buffer.trigger_late = (facts.flags & kFrameTriggerLate) != 0;
    buffer.mode = mode_;
    buffer.stride = packed_stride(mode_.format, mode_.width);
    buffer.pixels = bytes;
    buffer.lease = BufferLease(*this, static_cast<int>(free));
    room_ = std::move(*next_);
    next_.reset();
    return buffer;
  }

  Storage& storage_;
  const std::string path_;
  const ReplayPace pace_;
  Clock& clock_;
  CameraCapabilities capabilities_;
  StreamMode mode_;

  mutable std::mutex mutex_;  // of everything below
  std::condition_variable changed_;
  bool started_ = false;
  std::unique_ptr<RecordingReader> reader_;
  std::optional<RawFrame> next_;
  RawFrame room_;                // the frame before it, for its memory
  Instant due_;                  // when the frame read ahead is, by this replay's clock
  Instant last_;                 // of the frame read last, as recorded
  std::uint64_t delivered_ = 0;  // frames
  std::vector<std::vector<std::byte>> buffers_;
  std::vector<bool> in_use_;
  std::vector<std::uint64_t> cookies_;  // of the queued requests, a ring
  std::size_t first_cookie_ = 0, queued_ = 0;
};

}  // namespace

Result<std::unique_ptr<Camera>> open_replayed_camera(Storage& storage, const std::string& path,
                                                     ReplayPace pace, Clock& clock) {
  const auto reader = TRY(open_recording(storage, path, Damage::IsSkipped));
  const CameraFacts& facts = reader->camera();
  const auto format = format_for(facts.layout, facts.bits);
  if (!format)
    return Error{
        ErrorCode::Unsupported,
        fmt::format(
            "'{}' holds {} of {} bits, for which there is no pixel format of a camera; read it without "
            "--pace realtime",
            path, name(facts.layout), facts.bits)};
  return std::unique_ptr<Camera>(std::make_unique<ReplayedCamera>(
      storage, path, facts, *format, TRY(first_facts(*reader, path)), pace, clock));
}

}  // namespace hdrcam
