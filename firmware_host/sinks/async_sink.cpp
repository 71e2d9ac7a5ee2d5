#include "firmware_host/sinks/async_sink.h"

#include <algorithm>
#include <utility>

#include "hal/core/cpu.h"
#include "hal/core/stopwatch.h"
#include "hal/core/thread_name.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {
namespace {

void copy(const HdrFrame& from, HdrFrame& to) {
  to.head() = from.head();
  for (const auto layer : kFloatLayers) (to.*layer).copy_from(from.*layer);
  to.provenance.copy_from(from.provenance);
  to.points = from.points;
}

std::uint64_t bytes_of(const HdrFrame& frame) {
  std::size_t floats = 0;
  for (const auto layer : kFloatLayers) floats += (frame.*layer).size();
  return floats * sizeof(float) + frame.provenance.size() + frame.points.size() * sizeof(SurfacePoint);
}

}  // namespace

AsyncSink::AsyncSink(std::unique_ptr<FrameSink> sink, WhenFull when_full, ThreadPriority priority,
                     const std::string& name, Trace* trace)
    : sink_(std::move(sink)),
      input_use_(sink_->input_use()),
      when_full_(when_full),
      trace_(trace),
      thread_([this, priority, name] {
        name_this_thread(name);
        if (priority != ThreadPriority::Usual) set_priority_of_this_thread(priority);
        flush_denormals();
        work();
      }) {}

AsyncSink::~AsyncSink() { end(); }

std::size_t AsyncSink::slots_for(std::uint64_t frame_bytes) {
  return std::clamp<std::size_t>(kMostBytes / std::max<std::uint64_t>(1, frame_bytes), 1, kDepth + 1);
}

Result<void> AsyncSink::emit(const EmittedFrame& frame) {
  if (slots_.empty()) {  // its thread looks at them once there is a frame
    const std::size_t codes = input_use_ == InputUse::Codes ? frame.input.codes.size() : 0;
    slots_ = std::vector<Slot>(slots_for(bytes_of(frame.hdr) + codes * sizeof(float)));
  }
  const std::size_t slots = slots_.size();
  Slot* slot = nullptr;
  {
    std::unique_lock lock(mutex_);
    if (when_full_ == WhenFull::Wait) changed_.wait(lock, [&] { return count_ < slots || failed(); });
    if (failed()) return failure();
    if (count_ == slots) return ++times_.left_out, Result<void>{};
    slot = &slots_[(begin_ + count_) % slots];
  }
  // The slot is free and only this thread fills slots, so no lock is needed.
  copy(frame.hdr, slot->hdr);
  if (input_use_ == InputUse::Codes)
    copy(frame.input, slot->input);
  else
    copy_all_but_codes(frame.input, slot->input);
  slot->record = frame.record;
  {
    const std::lock_guard lock(mutex_);
    ++count_;
  }
  changed_.notify_all();
  return {};
}

void AsyncSink::work() {
  for (;;) {
    const Slot* slot = nullptr;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return count_ > 0 || closed_; });
      if (count_ == 0) return;
      slot = &slots_[begin_];
    }
    Stopwatch watch;
    Result<void> emitted;
    std::exception_ptr thrown = thrown_by([&] {
      const TraceSpan span(trace_, "emit", static_cast<std::int64_t>(slot->hdr.facts.sequence));
      emitted = sink_->emit({slot->hdr, slot->input, slot->record});
    });
    const double ms = watch.lap_ms();
    {
      const std::lock_guard lock(mutex_);
      result_ = std::move(emitted), thrown_ = std::move(thrown);
      times_.frames += failed() ? 0 : 1;
      times_.total_ms += ms, times_.longest_ms = std::max(times_.longest_ms, ms);
      begin_ = (begin_ + 1) % slots_.size(), --count_;
      if (failed()) return count_ = 0, changed_.notify_all();  // drops the rest
    }
    changed_.notify_all();
  }
}

void AsyncSink::end() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Result<void> AsyncSink::finish() {
  end();
  if (failed()) return failure();
  return sink_->finish();
}

Result<void> AsyncSink::failure() const {
  if (thrown_ != nullptr) std::rethrow_exception(thrown_);
  return result_;
}

SinkTimes AsyncSink::times() const {
  const std::lock_guard lock(mutex_);
  return times_;
}

}  // namespace hdrcam
