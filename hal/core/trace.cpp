#include "hal/core/trace.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "hal/core/json_text.h"
#include "hal/core/thread_name.h"

namespace hdrcam {
namespace {

double microseconds(Trace::Clock::duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

std::string json_string(std::string_view text) { return json_text(nlohmann::json(text)); }

}  // namespace

Trace::Trace(std::size_t most_spans) : most_spans_(most_spans) {
  constexpr std::size_t kThreads = 64;  // of most runs
  spans_.reserve(most_spans);
  threads_.reserve(kThreads);
}

std::size_t Trace::this_thread() {
  const int id = gettid();
  const auto place =
      static_cast<std::size_t>(std::ranges::find(threads_, id, &Thread::id) - threads_.begin());
  if (place == threads_.size()) threads_.push_back({id, name_of_this_thread(), start_});
  return place;
}

void Trace::add(std::string_view name, Clock::time_point begin, Clock::time_point end, std::int64_t frame) {
  const std::lock_guard lock(mutex_);
  const std::size_t thread = this_thread();
  threads_[thread].last_end = end;
  if (spans_.size() == most_spans_) return void(++left_out_);
  spans_.push_back({name, begin, end, frame, thread});
}

void Trace::add_stage(std::string_view name, double ms) {
  const auto end = Clock::now();
  const auto begin =
      end - std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(ms));
  Clock::time_point last_end;
  {
    const std::lock_guard lock(mutex_);
    last_end = threads_[this_thread()].last_end;
  }
  add(name, std::max(begin, last_end), end);
}

std::uint64_t Trace::left_out() const {
  const std::lock_guard lock(mutex_);
  return left_out_;
}

std::string Trace::json() const {
  const std::lock_guard lock(mutex_);
  std::vector<const Span*> sorted;
  for (const Span& span : spans_) sorted.push_back(&span);
  // By thread and time; of two that begin together the outer one first.
  std::ranges::sort(sorted, [](const Span* a, const Span* b) {
    if (a->thread != b->thread) return a->thread < b->thread;
    return a->begin != b->begin ? a->begin < b->begin : a->end > b->end;
  });
  const int process = getpid();
  std::string text = fmt::format(
      "{{\"displayTimeUnit\":\"ms\",\"otherData\":{{\"left_out\":{}}},\"traceEvents\":[\n"
      "{{\"ph\":\"M\",\"name\":\"process_name\",\"pid\":{},\"args\":{{\"name\":\"hdrcam\"}}}}",
      left_out_, process);
  for (const Thread& thread : threads_)
    text += fmt::format(
        ",\n{{\"ph\":\"M\",\"name\":\"thread_name\",\"pid\":{},\"tid\":{},\"args\":{{\"name\":{}}}}}",
        process, thread.id, json_string(thread.name));
  for (const Span* span : sorted) {
    text += fmt::format(",\n{{\"ph\":\"X\",\"name\":{},\"pid\":{},\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f}",
                        json_string(span->name), process, threads_[span->thread].id,
                        microseconds(span->begin - start_), microseconds(span->end - span->begin));
    if (span->frame >= 0) text += fmt::format(",\"args\":{{\"frame\":{}}}", span->frame);
    text += '}';
  }
  return text + "\n]}\n";
}

}  // namespace hdrcam
