// The account of trigger pulses: how late their edges were, and what the sensor answered on the strobe line.
// A pulse's answer is the first leading edge from a little before the pulse until half an interval after it;
// a pulse without one, and a leading edge without a pulse, are counted and named. Of pulses that were driven
// while the ring of the trigger was full there is no record: they count, and an answer between the pulses
// around them is theirs; nobody knows which of them were late or unanswered. A line loses edges of a reader
// that is late: a pulse whose answer may be among them does not count as unanswered. Thread-bound; bounded
// state, no allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "capture/edge_errors.h"
#include "capture/pulse_train.h"
#include "hal/sync_line.h"

namespace hdrcam {

struct TriggerCounters {
  static constexpr std::size_t kNamed = 3;

  std::uint64_t pulses = 0;  // driven
  std::uint64_t late = 0;    // of them
  // Instants without a pulse: its thread was so late that it would have met the next.
  std::uint64_t left_out = 0;
  std::uint64_t answered = 0, unanswered = 0;
  std::uint64_t spurious = 0;                        // answers without a pulse
  std::array<std::uint64_t, kNamed> missing{};       // numbers of the first unanswered pulses
  std::array<Instant, kNamed> spurious_at{};         // the first answers without a pulse
  Duration edge_mean{0}, edge_p99{0}, edge_most{0};  // distance of edges from where they were planned
};

class TriggerLedger {
 public:
  void start(const TriggerOptions& options);
  // Pulses and edges, each in order; then what is settled at `until`, when both have come.
  void pulse(const TriggerPulse& pulse);
  void answer(const Edge& edge);
  void settle(Instant until);
  // No further pulse comes; so many were driven since the start.
  void end(std::uint64_t driven) { unrecorded_ += count_unrecorded(driven); }
  const TriggerCounters& counters() const { return counters_; }

 private:
  // Pulses and edges that are not settled. A consumer that is late brings all pulses that were driven
  // meanwhile before their answers.
  static constexpr std::size_t kOpen = 2 * kMostWaitingPulses;
  template <class T>
  struct Ring {
    std::array<T, kOpen> items{};
    std::uint64_t put = 0, taken = 0;

    bool empty() const { return taken == put; }
    bool full() const { return put - taken == kOpen; }
    T& front() { return items[taken % kOpen]; }
    void push(const T& item) { items[put++ % kOpen] = item; }
  };
  struct Expected {
    std::uint64_t number = 0;
    Instant from, until;                  // of the answer
    std::uint64_t unrecorded_before = 0;  // pulses whose answers have not come
  };

  struct LeadingEdge {
    Instant at;
    bool after_lost_ones = false;  // edges between the leading edge before it and this one
  };

  std::uint64_t count_unrecorded(std::uint64_t driven);
  bool settle_one(Instant until);
  void count_answer_beside(std::uint64_t& unrecorded, Instant at);
  void count_missing(const Expected& pulse);

  TriggerOptions options_;
  EdgeErrors errors_;
  std::uint64_t next_number_ = 0, next_index_ = 0;
  std::uint64_t unrecorded_ = 0;  // after the last pulse, without an answer
  Ring<Expected> expected_;
  Ring<LeadingEdge> answers_;
  std::optional<std::uint64_t> last_edge_;  // its sequence number
  bool edges_lost_ = false;                 // since the last leading edge
  TriggerCounters counters_;
};

// Whether there is a strobe line on which the sensor answers.
enum class TriggerAnswers { Heard, NotHeard };

// Returns text like "trigger 'FSYNC' (pulse width): 300 pulses, 2 late (more than 500 us), 0 left out; edges
// 12 us off on average, 99 % within 45 us, at most 610 us; 299 answered, 1 not (pulse 17), 0 answers without
// a pulse"; of answers only where they are heard.
std::string sentence_of(const TriggerCounters& counters, const std::string& line,
                        const TriggerOptions& options, TriggerAnswers answers);

}  // namespace hdrcam
