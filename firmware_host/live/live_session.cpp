#include "firmware_host/live/live_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>

#include "firmware_host/no_further_thread.h"
#include "hal/clock.h"
#include "hal/core/thread_name.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {
namespace {

int frames_in(std::size_t bytes, const CameraFacts& camera) {
  const std::size_t frame = sizeof(std::uint16_t) * static_cast<std::size_t>(camera.width) *
                            static_cast<std::size_t>(camera.height) *
                            static_cast<std::size_t>(channels(camera.layout));
  return static_cast<int>(std::clamp<std::size_t>(bytes / std::max<std::size_t>(1, frame),
                                                  LiveOptions::kFewestFrames, LiveOptions::kMostFrames));
}

// One second of them, and no more than half of the pool: the recorder waits for a disk with the other half.
int most_waiting(const CameraFacts& camera, int pool, int slots) {
  const int two_cycles = 2 * slots + 1;
  return std::max(two_cycles, std::min(static_cast<int>(std::lround(camera.framerate_hz)), pool / 2));
}

Error no_further_frame() { return {ErrorCode::Interrupted, "the run ends; no further frame is captured"}; }

}  // namespace

LiveSession::LiveSession(CaptureStage& capture, std::unique_ptr<RecordingWriter> recording,
                         const LiveOptions& options)
    : capture_(capture),
      options_(options),
      pool_(frames_in(options.memory_bytes, capture.facts()), capture.facts()),
      inbox_(capture.schedule().slots(),
             most_waiting(capture.facts(), pool_.size(), capture.schedule().slots())) {
  scratch_.raw.codes.reshape(channels(capture.facts().layout), capture.facts().height, capture.facts().width);
  if (recording) own_ = recorder_ = recorder_of(std::move(recording), StartedBy::Run);
}

std::shared_ptr<Recorder> LiveSession::recorder_of(std::unique_ptr<RecordingWriter> recording,
                                                   StartedBy started_by) {
  const auto written = [this, started_by] {
    const std::lock_guard lock(mutex_);
    ++counters_.recorded, --counters_.to_record;
    counters_.in_takes += started_by == StartedBy::Person;
  };
  return std::make_shared<Recorder>(std::move(recording), pool_.size(), written, options_.trace);
}

LiveSession::~LiveSession() { end(); }

Result<void> LiveSession::start(const std::atomic<bool>& stop) {
  TRY(capture_.start());
  begin_ = posix_clock().now();
  thread_ = std::thread([this, &stop] { capture_frames(stop); });
  return {};
}

void LiveSession::capture_frames(const std::atomic<bool>& stop) {
  name_this_thread("capture");
  Result<void> stopped;
  thrown_ = thrown_by([&] { capture_result_ = capture_until_end(stop); });
  const std::exception_ptr thrown_at_end = thrown_by([&] {
    stopped = capture_.stop();
    capture_.settle_trigger();
  });
  if (capture_result_ && thrown_ == nullptr) capture_result_ = stopped, thrown_ = thrown_at_end;
  {
    const std::lock_guard lock(mutex_);
    counters_.ended = true;
    if (recorder_) recorder_->close();  // its end is written now, whatever the fit and the outputs still take
    if (auto wanted = std::exchange(wanted_cycle_, std::nullopt)) wanted->done.set_value(no_further_frame());
  }
  inbox_.close();
}

Result<void> LiveSession::capture_until_end(const std::atomic<bool>& stop) {
  while (!ending_) {
    if (const auto why = reason_to_end(stop)) {
      why_ = *why;
      break;
    }
    const Result<void> captured = capture_one(stop);
    if (!captured && !(captured.error().code == ErrorCode::Interrupted && is_to_end(stop))) return captured;
    if (options_.frames > 0 && capture_.counters().emitted >= options_.frames) break;
  }
  return {};
}

Result<void> LiveSession::next_frame(CapturedFrame& captured, const std::atomic<bool>& stop) {
  const TraceSpan span(options_.trace, "capture");
  return capture_.next(captured, [this, &stop] { return is_to_end(stop); });
}

Result<void> LiveSession::capture_one(const std::atomic<bool>& stop) {
  take_feedback();
  take_cycle();
  FrameShare frame = pool_.take();
  CapturedFrame& captured = frame ? frame->captured : scratch_;
  TRY(next_frame(captured, stop));
  if (!frame && (frame = pool_.take()))
    std::swap(frame->captured, scratch_);  // a frame became free meanwhile
  if (!frame) {
    ++lost_here_;
    const std::lock_guard lock(mutex_);
    count_camera();
    ++counters_.pool_full;
    return {};
  }
  frame->arrived = posix_clock().now();
  if (lost_here_ > 0) {
    frame->captured.lost_before += std::exchange(lost_here_, 0);
    frame->captured.raw.facts.flags |= kFrameAfterDrop;
  }
  hand_on(std::move(frame));
  return {};
}

void LiveSession::count_camera() { counters_.camera = capture_.counters(); }

void LiveSession::hand_on(FrameShare frame) {
  const bool fits =
      options_.work == LiveWork::Fit && (frame->captured.raw.facts.flags & kFrameExposureUnproved) == 0;
  std::shared_ptr<Recorder> recorder;
  {
    const std::lock_guard lock(mutex_);
    count_camera();
    if (!first_arrival_) first_arrival_ = frame->arrived;
    if (fits)
      ++counters_.in_fit;
    else if (options_.work == LiveWork::Fit)
      ++counters_.unproved;
    recorder = recorder_;
    ++(recorder ? counters_.to_record : counters_.not_requested);
  }
  if (recorder && !recorder->put(frame.another())) {  // it was closed meanwhile
    const std::lock_guard lock(mutex_);
    --counters_.to_record, ++counters_.not_requested;
  }
  if (!fits) return;
  if (const int shed = inbox_.put(std::move(frame)); shed > 0) {
    const std::lock_guard lock(mutex_);
    count_shed(shed);
  }
}

void LiveSession::count_shed(int frames) {
  counters_.shed += static_cast<std::uint64_t>(frames);
  counters_.in_fit -= static_cast<std::uint64_t>(frames);
}

void LiveSession::take_feedback() {
  const std::lock_guard lock(mutex_);
  if (learned_) capture_.learn_response(learned_->inverse, learned_->black_level);
  if (followed_) (void)capture_.change_cycle(*followed_);  // follow() checked it
  learned_.reset(), followed_.reset();
}

FrameShare LiveSession::next(const std::function<void()>& tick) {
  constexpr Duration kTick = std::chrono::milliseconds(100);
  for (;;) {
    if (tick) tick();
    FitInbox::Taken taken = inbox_.take(kTick);
    if (taken.frame) {
      const std::lock_guard lock(mutex_);
      count_shed(taken.shed);
      ++counters_.taken;
      arrivals_[arrival_count_++ % arrivals_.size()] = {taken.frame->captured.raw.facts.sequence,
                                                        taken.frame->arrived};
    }
    if (taken.frame || inbox_.ended()) return std::move(taken.frame);
  }
}

std::optional<LiveEnd> LiveSession::reason_to_end(const std::atomic<bool>& stop) const {
  if (stop) return LiveEnd::Stopped;
  {
    const std::lock_guard lock(mutex_);
    for (const auto* recorder : {recorder_.get(), completing_.get()})
      if (recorder != nullptr && recorder->failed()) return LiveEnd::Stopped;
  }
  if (options_.timeout > Duration::zero() && posix_clock().now() - begin_ >= options_.timeout)
    return LiveEnd::Timeout;
  return std::nullopt;
}

bool LiveSession::is_to_end(const std::atomic<bool>& stop) const {
  return ending_ || reason_to_end(stop).has_value();
}

Duration LiveSession::emitted(std::uint64_t sequence) {
  const Instant now = posix_clock().now();
  const std::lock_guard lock(mutex_);
  if (counters_.emitted == 0 && first_arrival_) counters_.first_frame = now - *first_arrival_;
  ++counters_.emitted, --counters_.in_fit;
  for (const Arrival& arrival : arrivals_)
    if (arrival.sequence == sequence && arrival.at.since_boot > Duration::zero()) {
      counters_.latency = now - arrival.at;
      counters_.longest_latency = std::max(counters_.longest_latency, counters_.latency);
      return counters_.latency;
    }
  return Duration::zero();
}

void LiveSession::left_out() {
  const std::lock_guard lock(mutex_);
  ++counters_.left_out, --counters_.in_fit;
}

Result<void> LiveSession::finish_recordings() {
  std::shared_ptr<Recorder> recorders[2];
  {
    const std::lock_guard lock(mutex_);
    recorders[0] = completing_, recorders[1] = recorder_;
  }
  for (const auto& recorder : recorders)
    if (recorder != nullptr) recorder->complete();  // each, before one throws
  Result<void> first;
  for (const auto& recorder : recorders)
    if (recorder != nullptr)
      if (const Result<void> recorded = recorder->outcome(); first && !recorded) first = recorded;
  return first;
}

void LiveSession::end() {
  if (std::exchange(finished_, true)) return;
  ending_ = true;
  if (thread_.joinable()) thread_.join();
  while (inbox_.take(Duration::zero()).frame) {
  }
  Result<void> recorded;
  const std::exception_ptr not_recorded = thrown_by([&] { recorded = finish_recordings(); });
  const std::lock_guard lock(mutex_);
  count_camera();
  counters_.unfinished += std::exchange(counters_.in_fit, 0);
  counters_.unwritten += std::exchange(counters_.to_record, 0);
  if (!recorded) capture_result_ = recorded;
  if (not_recorded != nullptr) thrown_ = not_recorded;
}

Result<LiveEnd> LiveSession::finish() {
  end();
  if (thrown_ != nullptr) std::rethrow_exception(thrown_);
  if (!capture_result_) return capture_result_.error();
  return why_;
}

std::optional<std::uint64_t> LiveSession::recording_cut_after() const {
  const std::lock_guard lock(mutex_);
  if (own_ == nullptr || !own_->failed()) return std::nullopt;
  return counters_.recorded - counters_.in_takes;
}

bool LiveSession::last_take_failed() const {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(std::array{recorder_, completing_}, [&](const auto& recorder) {
    return recorder != nullptr && recorder != own_ && recorder->failed();
  });
}

void LiveSession::learn_response(const PhotometricResponse::Curve& inverse, const BlackLevel& black_level) {
  const std::lock_guard lock(mutex_);
  learned_ = {inverse, black_level};
}

Result<void> LiveSession::follow(const std::vector<Exposure>& cycle) {
  TRY(capture_.schedule_of(cycle));
  const std::lock_guard lock(mutex_);
  followed_ = cycle;
  return {};
}

Result<void> LiveSession::may_record() const {
  const std::lock_guard lock(mutex_);
  return may_record_under_lock();
}

Result<void> LiveSession::may_record_under_lock() const {
  if (recorder_) return Error{ErrorCode::Busy, "a recording is open; stop it first"};
  if (completing_ && !completing_->ended())
    return Error{ErrorCode::Busy, "the last recording is still being completed; try again"};
  if (completing_) TRY(completing_->outcome());
  return counters_.ended ? no_further_frame() : Result<void>();
}

Result<void> LiveSession::start_recording(std::unique_ptr<RecordingWriter> recording) {
  std::shared_ptr<Recorder> completed;  // goes without the lock: its thread is waited for
  const std::lock_guard lock(mutex_);
  TRY(may_record_under_lock());
  try {
    recorder_ = recorder_of(std::move(recording), StartedBy::Person);
  } catch (const std::system_error&) {
    return no_further_thread();
  }
  completed = std::exchange(completing_, nullptr);
  return {};
}

Result<void> LiveSession::stop_recording() {
  const std::lock_guard lock(mutex_);
  if (!recorder_) return Error{ErrorCode::NotFound, "nothing is being recorded"};
  completing_ = std::exchange(recorder_, nullptr);
  completing_->close();
  return {};
}

Result<void> LiveSession::change_cycle(std::vector<Exposure> cycle) {
  constexpr int kFrames = 3;  // the camera takes it between two of them
  const Duration patience =
      std::max<Duration>(std::chrono::seconds(2), kFrames * capture_.mode().frame_duration);
  std::future<Result<void>> done;
  {
    const std::lock_guard lock(mutex_);
    if (counters_.ended) return no_further_frame();
    wanted_cycle_.emplace(WantedCycle{std::move(cycle), {}});
    done = wanted_cycle_->done.get_future();
  }
  if (done.wait_for(patience) == std::future_status::ready) return done.get();
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(wanted_cycle_, std::nullopt)) return done.get();  // taken at the last moment
  }
  return Error{ErrorCode::Timeout, "the camera delivers no frames; its cycle is as it was"};
}

void LiveSession::take_cycle() {
  std::optional<WantedCycle> wanted;
  {
    const std::lock_guard lock(mutex_);
    if (!wanted_cycle_) return;
    wanted = std::exchange(wanted_cycle_, std::nullopt);
  }
  Result<void> adopted;
  const std::exception_ptr thrown = thrown_by([&] { adopted = adopt_cycle(wanted->exposures); });
  if (thrown == nullptr)
    wanted->done.set_value(std::move(adopted));
  else
    wanted->done.set_exception(thrown);
}

Result<void> LiveSession::adopt_cycle(std::span<const Exposure> cycle) {
  const auto slots = static_cast<std::size_t>(capture_.schedule().slots());
  if (cycle.size() != slots)
    return Error{
        ErrorCode::Invalid,
        fmt::format("the cycle of this run has {} exposures, not {}; give as many", slots, cycle.size())};
  return capture_.change_cycle(cycle);
}

LiveCounters LiveSession::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

}  // namespace hdrcam
