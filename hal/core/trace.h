// What each thread did when: named spans, written as Chrome's trace events, which ui.perfetto.dev and
// chrome://tracing show. Spans of one thread nest or follow each other. The memory is fixed; when it is full,
// further spans are left out and counted. Thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace hdrcam {

class Trace {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Trace(std::size_t most_spans = 1U << 20);  // 48 MiB, touched as it fills

  // A span of the calling thread, which has ended. name: of static storage; frame: its number, -1 for none.
  void add(std::string_view name, Clock::time_point begin, Clock::time_point end, std::int64_t frame = -1);
  // A stage that has just ended, of which only the duration is known. It begins no earlier than the thread's
  // last span ended.
  void add_stage(std::string_view name, double ms);

  // {"traceEvents": [..]}, the threads with their names (thread_name.h).
  std::string json() const;
  std::uint64_t left_out() const;

 private:
  struct Span {
    std::string_view name;
    Clock::time_point begin, end;
    std::int64_t frame;
    std::size_t thread;  // index
  };
  struct Thread {
    int id;
    std::string name;
    Clock::time_point last_end;
  };
  std::size_t this_thread();

  const Clock::time_point start_ = Clock::now();
  const std::size_t most_spans_;
  mutable std::mutex mutex_;  // guards the members below
  std::vector<Span> spans_;
  std::vector<Thread> threads_;
  std::uint64_t left_out_ = 0;
};

// A span from here to the end of the scope; nothing where there is no trace. Thread-bound.
class TraceSpan {
 public:
  TraceSpan(Trace* trace, std::string_view name, std::int64_t frame = -1)
      : trace_(trace), name_(name), frame_(frame) {}
  ~TraceSpan() {
    if (trace_ != nullptr) trace_->add(name_, begin_, Trace::Clock::now(), frame_);
  }
  TraceSpan(const TraceSpan&) = delete;
  TraceSpan& operator=(const TraceSpan&) = delete;

 private:
  Trace* const trace_;
  const std::string_view name_;
  const std::int64_t frame_;
  const Trace::Clock::time_point begin_ = Trace::Clock::now();
};

}  // namespace hdrcam
