#include "firmware_host/run/governor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "hal/core/check.h"
#include "hal/core/median.h"
#include "hal/core/quantile.h"

namespace hdrcam {
namespace {

// Shares of the deadline. A rung in use may fill the deadline, one that is returned to must leave room: the
// hysteresis.
constexpr double kSuddenlyLate = 1.15;
constexpr double kRoomToShedTo = 0.95;
constexpr double kRoomToReturn = 0.85;     // also of the rung below, to try one of unknown cost
constexpr double kRoomToEmitAll = 0.95;    // a frame that is left out is lost: there is less hysteresis
constexpr double kRoomBesideQueue = 0.95;  // to return, where a queue absorbs what is late
constexpr double kRoomToCatchUp = 0.8;     // under a backlog that lasts: the deadline itself

constexpr double kMostStep = 1.4;  // a rung's time over that of the next cheaper one

constexpr double kUpperQuartile = 0.75;

constexpr int kSettling = 1;                                 // frames
constexpr int kProven = 30;                                  // frames after which a return has held
constexpr int kLongestWait = 16;                             // in first waits
constexpr double kFirstWait_s = 4, kMostFirstWait = 10'000;  // the second in frames
constexpr double kFasterMachine = 0.85;  // of the steady work's time: another machine than before
constexpr double kLeastSteady_ms = 1e-3;

// Whether frames wait for each other, which evens out what they take.
bool queues(Backlog backlog) { return backlog != Backlog::Unknown; }

}  // namespace

Governor::Governor(std::vector<Rung> ladder, Duration deadline)
    : ladder_(std::move(ladder)),
      deadline_(deadline),
      deadline_ms_(to_seconds(deadline) * 1e3),
      first_wait_(static_cast<int>(
          std::lround(std::clamp(kFirstWait_s / to_seconds(deadline), 1.0, kMostFirstWait)))),
      ratios_(ladder_.size()),
      since_return_(kProven),
      to_return_{.next = first_wait_},
      to_leave_out_{.next = first_wait_},
      frames_at_(ladder_.size(), 0) {
  CHECK(!ladder_.empty() && deadline > Duration::zero());
  while (at_ + 1 < ladder_.size() && ladder_[at_ + 1].emits_all()) ++at_;
  emits_all_ = at_;
}

FrameBudget Governor::next() {
  const Rung& rung = ladder_[at_];
  FrameBudget budget = rung.budget;
  budget.emits = frames_++ % rung.of < rung.emitted;
  return budget;
}

void Governor::done(const FrameWork& work, Backlog backlog) {
  backlog_ = backlog;
  if (work.frames == 0) return;
  frames_at_[at_] += work.frames;
  if (work.frames > 1) return;  // the first frames come at once
  since_return_ = std::min(since_return_ + 1, kProven);
  pass_waits();
  add(work);
  if (samples_ % kWindow == 0 && samples_ > 0 && usual().total_ms <= deadline_ms_) remember();
  if (is_hopeless())
    give_up();
  else if (const auto cheaper = rung_to_shed_to())
    shed_to(*cheaper);
  else if (const auto better = rung_to_return_to())
    remember(), since_return_ = 0, move_to(*better);
}

// Frames of which not all are emitted count as their mean.
void Governor::add(const FrameWork& work) {
  pending_.total_ms += work.total_ms, pending_.steady_ms += work.steady_ms;
  if (++pending_frames_ < ladder_[at_].of) return;
  const Sample mean{pending_.total_ms / pending_frames_,
                    std::max(pending_.steady_ms / pending_frames_, kLeastSteady_ms)};
  if (mean.total_ms > deadline_ms_) late_ += pending_frames_;
  pending_ = {}, pending_frames_ = 0;
  if (unsettled_ > 0)
    --unsettled_;
  else
    window_[samples_++ % kWindow] = mean;
}

// Of the newest frames the one with the upper quartile of the time: two outliers of eight do not count.
Governor::Sample Governor::upper(std::size_t newest) const {
  std::array<Sample, kWindow> sorted{};
  for (std::size_t i = 0; i < newest; ++i) sorted[i] = window_[(samples_ - 1 - i) % kWindow];
  return quantile(std::span(sorted).first(newest), kUpperQuartile,
                  [](const Sample& a, const Sample& b) { return a.total_ms < b.total_ms; });
}

// Of the window, in which the longest frame, perhaps an outlier, counts as the second longest.
Governor::Sample Governor::mean() const {
  const std::size_t count = std::min(samples_, kWindow);
  CHECK(count > 1);
  Sample sum, longest, second;
  for (std::size_t i = 0; i < count; ++i) {
    const Sample& sample = window_[i];
    sum.total_ms += sample.total_ms, sum.steady_ms += sample.steady_ms;
    const bool longer = sample.total_ms > longest.total_ms;
    if (longer || sample.total_ms > second.total_ms) second = longer ? longest : sample;
    if (longer) longest = sample;
  }
  const auto n = static_cast<double>(count);
  return {(sum.total_ms - longest.total_ms + second.total_ms) / n,
          (sum.steady_ms - longest.steady_ms + second.steady_ms) / n};
}

// What a frame takes. Frames of a cycle are uneven: those whose long exposure is clipped take half as long
// again. A queue evens them out; without one all have to be in time.
Governor::Sample Governor::usual() const {
  return queues(backlog_) ? mean() : upper(std::min(samples_, kWindow));
}

// The speed of the machine: the usual time of the steady work, as ratios are over it.
double Governor::steady_ms() const {
  if (queues(backlog_)) return mean().steady_ms;
  const std::size_t count = std::min(samples_, kWindow);
  std::array<double, kWindow> sorted{};
  for (std::size_t i = 0; i < count; ++i) sorted[i] = window_[i].steady_ms;
  return median(std::span(sorted).first(count));
}

std::optional<std::size_t> Governor::rung_to_shed_to() const {
  if (at_ + 1 == end() || samples_ < kSudden || backlog_ == Backlog::None) return std::nullopt;
  const bool sudden = upper(kSudden).total_ms > kSuddenlyLate * allowed_ms();
  // Frames of uneven cost wait for each other: none is left out before they are late in the mean.
  const double late_ms = at_ < emits_all_ ? usual().total_ms : mean().total_ms;
  const bool steady = samples_ >= kWindow && late_ms > allowed_ms();
  if (!sudden && !steady) return std::nullopt;
  const Sample now = sudden ? upper(kSudden) : usual();
  for (std::size_t r = at_ + 1; r < end(); ++r) {
    const auto ratio = expected_ratio(r, now.ratio());
    if (!ratio || *ratio * now.steady_ms <= kRoomToShedTo * allowed_ms()) return r;
  }
  return end() - 1;
}

// Of a cheaper rung; one that was never in use lies evenly between the present one and the next known one.
std::optional<double> Governor::expected_ratio(std::size_t rung, double present) const {
  std::size_t known = rung;
  while (known < ratios_.size() && !ratios_[known]) ++known;
  if (known == ratios_.size()) return std::nullopt;
  const double way = static_cast<double>(rung - at_) / static_cast<double>(known - at_);
  return present + (*ratios_[known] - present) * way;
}

std::optional<std::size_t> Governor::rung_to_return_to() const {
  const bool some_wait = queues(backlog_) && backlog_ != Backlog::None;
  if (at_ == 0 || samples_ < kTrial || some_wait) return std::nullopt;
  if (samples_ >= kWindow)
    for (std::size_t r = 0; r < at_; ++r) {
      const double room = r == emits_all_ ? kRoomToEmitAll : room_to_return();
      if (ratios_[r] && !is_blocked(r) && *ratios_[r] * steady_ms() <= room * deadline_ms_) return r;
    }
  return rung_to_try();
}

// The best rung of unknown cost that may fit, if each takes up to kMostStep times as long as the one below;
// of the next one it is enough that the present one leaves room.
std::optional<std::size_t> Governor::rung_to_try() const {
  const double room_ms = room_to_return() * deadline_ms_;
  double most_ms = usual().total_ms;
  if (most_ms > room_ms) return std::nullopt;
  std::size_t best = at_;
  while (best > 0 && !ratios_[best - 1] && !is_blocked(best - 1)) {
    most_ms *= kMostStep;
    if (best < at_ && most_ms > room_ms) break;
    --best;
  }
  return best < at_ ? std::optional(best) : std::nullopt;
}

void Governor::begin(Wait& wait) const {
  wait = {wait.next, std::min(2 * wait.next, kLongestWait * first_wait_), steady_ms()};
}

bool Governor::is_faster_than_in(const Wait& wait) const {
  return steady_ms() <= kFasterMachine * wait.steady_ms;
}

bool Governor::is_blocked(std::size_t rung) const {
  return rung <= blocked_ && to_return_.frames_left > 0 && !is_faster_than_in(to_return_);
}

// Of the rungs that are in use at present.
std::size_t Governor::end() const {
  const bool absorbs = queues(backlog_) && backlog_ != Backlog::Pressing;
  const bool emits_all = to_leave_out_.frames_left > 0 || (absorbs && at_ <= emits_all_);
  return emits_all ? emits_all_ + 1 : ladder_.size();
}

double Governor::room_to_return() const {
  return backlog_ == Backlog::None ? kRoomBesideQueue : kRoomToReturn;
}

double Governor::allowed_ms() const {
  const bool catches_up = backlog_ == Backlog::Lasting || backlog_ == Backlog::Pressing;
  return deadline_ms_ * (catches_up ? kRoomToCatchUp : 1);
}

// What this rung takes, learned from frames in time: late ones tell more about the moment than about the
// rung.
void Governor::remember() {
  if (queues(backlog_)) {
    ratios_[at_] = mean().ratio();
    return;
  }
  const std::size_t count = std::min(samples_, kWindow);
  std::array<double, kWindow> ratios{};
  for (std::size_t i = 0; i < count; ++i) ratios[i] = window_[i].ratio();
  ratios_[at_] = quantile(std::span(ratios).first(count), kUpperQuartile);
}

void Governor::shed_to(std::size_t rung) {
  const bool failed = since_return_ < kProven;
  if (failed || !ratios_[at_]) remember();
  if (failed) blocked_ = at_, begin(to_return_);
  since_return_ = kProven;
  move_to(rung);
}

void Governor::move_to(std::size_t rung) {
  at_ = rung;
  samples_ = 0, unsettled_ = kSettling;
  pending_ = {}, pending_frames_ = 0;
}

// A return that held, or another machine, makes the next wait short again. A rung that waited to its end is
// one of unknown cost.
void Governor::pass_waits() {
  if (since_return_ == kProven && at_ <= blocked_) to_return_.next = first_wait_;
  if (to_return_.frames_left > 0 && --to_return_.frames_left == 0) ratios_[blocked_].reset();
  if (to_leave_out_.frames_left > 0 && samples_ >= kWindow && is_faster_than_in(to_leave_out_))
    to_leave_out_ = {.next = first_wait_};
  to_leave_out_.frames_left = std::max(to_leave_out_.frames_left - 1, 0);
}

// Whether the rung that leaves out most is too slow.
bool Governor::is_hopeless() const {
  return at_ + 1 == ladder_.size() && at_ > emits_all_ && samples_ >= kWindow / 2 &&
         (queues(backlog_) ? mean() : upper(kWindow / 2)).total_ms > deadline_ms_;
}

void Governor::give_up() {
  begin(to_leave_out_);
  move_to(emits_all_);
}

}  // namespace hdrcam
