#include "capture/trigger_ledger.h"

#include <algorithm>
#include <utility>

#include "hal/core/counted.h"

namespace hdrcam {
namespace {

// An answer's stamp may be earlier than the pulse's: the interrupt comes while the call that drives the line
// has not returned.
constexpr Duration kEarly = std::chrono::microseconds(500);

}  // namespace

void TriggerLedger::start(const TriggerOptions& options) {
  *this = {};
  options_ = options;
}

// The pulses that were driven since the last one that was told of.
std::uint64_t TriggerLedger::count_unrecorded(std::uint64_t driven) {
  const std::uint64_t unrecorded = driven - next_index_;
  next_index_ = driven;
  counters_.pulses += unrecorded;
  return unrecorded;
}

void TriggerLedger::pulse(const TriggerPulse& pulse) {
  const std::uint64_t unrecorded = count_unrecorded(pulse.index);
  ++counters_.pulses, ++next_index_;
  counters_.late += pulse.late;
  counters_.left_out += pulse.planned.number - next_number_ - unrecorded;
  next_number_ = pulse.planned.number + 1;
  errors_.add(pulse.begin_error());
  errors_.add(pulse.width_error());
  counters_.edge_mean = errors_.mean();
  counters_.edge_p99 = errors_.p99();
  counters_.edge_most = errors_.most();
  while (expected_.full()) (void)settle_one(expected_.front().until);
  expected_.push({pulse.planned.number, pulse.rise.at + -(kEarly + pulse.rise.within),
                  pulse.rise.at + options_.interval / 2, unrecorded});
}

void TriggerLedger::answer(const Edge& edge) {
  edges_lost_ = edges_lost_ || (last_edge_ && edge.sequence > *last_edge_ + 1);
  last_edge_ = edge.sequence;
  if (!edge.rising) return;
  while (answers_.full()) (void)settle_one(answers_.front().at);
  answers_.push({edge.at, std::exchange(edges_lost_, false)});
}

void TriggerLedger::count_missing(const Expected& pulse) {
  if (!answers_.empty() && answers_.front().after_lost_ones) return;
  if (counters_.unanswered < counters_.missing.size()) counters_.missing[counters_.unanswered] = pulse.number;
  ++counters_.unanswered;
}

// An answer that is to no recorded pulse.
void TriggerLedger::count_answer_beside(std::uint64_t& unrecorded, Instant at) {
  if (unrecorded > 0) {
    --unrecorded, ++counters_.answered;
    return;
  }
  if (counters_.spurious < counters_.spurious_at.size()) counters_.spurious_at[counters_.spurious] = at;
  ++counters_.spurious;
}

// Settles the older of the oldest pulse and the oldest answer. False where neither is old enough.
bool TriggerLedger::settle_one(Instant until) {
  const bool expected = !expected_.empty(), answered = !answers_.empty();
  if (expected && answered && answers_.front().at >= expected_.front().from &&
      answers_.front().at <= expected_.front().until) {
    ++counters_.answered, ++expected_.taken, ++answers_.taken;
    return true;
  }
  if (answered && (!expected || answers_.front().at < expected_.front().from)) {
    if (answers_.front().at > until) return false;
    count_answer_beside(expected ? expected_.front().unrecorded_before : unrecorded_, answers_.front().at);
    ++answers_.taken;
    return true;
  }
  if (!expected || (!answered && expected_.front().until > until)) return false;
  count_missing(expected_.front());
  ++expected_.taken;
  return true;
}

void TriggerLedger::settle(Instant until) {
  while (settle_one(until)) {
  }
}

std::string sentence_of(const TriggerCounters& counters, const std::string& line,
                        const TriggerOptions& options, TriggerAnswers answers) {
  const auto us = [](Duration time) { return fmt::format("{:.0f} us", to_seconds(time) * 1e6); };
  std::string text = fmt::format(
      "trigger '{}' ({}): {}, {} late (more than {}), {} left out; edges {} off on average, 99 % "
      "within {}, at most {}",
      line, options.mode == TriggerMode::PulseWidth ? "pulse width" : "frame start",
      counted(counters.pulses, "pulse"), counters.late, us(options.tolerance), counters.left_out,
      us(counters.edge_mean), us(counters.edge_p99), us(counters.edge_most));
  if (answers == TriggerAnswers::NotHeard) return text;
  text += fmt::format("; {} answered, {} not", counters.answered, counters.unanswered);
  const auto named = std::min<std::uint64_t>(counters.unanswered, counters.missing.size());
  for (std::size_t i = 0; i < named; ++i)
    text += fmt::format("{}{}", i == 0 ? " (pulse " : ", ", counters.missing[i]);
  if (named > 0) text += counters.unanswered > named ? ", ..)" : ")";
  text += fmt::format(", {} without a pulse", counted(counters.spurious, "answer"));
  if (counters.spurious > 0)
    text += fmt::format(" (the first at {:.6f} s)", counters.spurious_at[0].seconds());
  return text;
}

}  // namespace hdrcam
