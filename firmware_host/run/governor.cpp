#include "firmware_host/run/governor.h"

#include <algorithm>
#include <utility>

#include "hal/core/check.h"

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

// Frame times on the present rung.
constexpr std::size_t kWindow = RungTimes::kWindow;
constexpr std::size_t kSudden = 2, kHopeless = kWindow / 2, kTrial = 5;

constexpr int kProven = 30;  // frames after which a return has held

// Whether frames wait for each other, which evens out what they take.
bool queues(Backlog backlog) { return backlog != Backlog::Unknown; }

}  // namespace

Governor::Governor(std::vector<Rung> ladder, Duration deadline)
    : ladder_(std::move(ladder)),
      deadline_(deadline),
      deadline_ms_(to_seconds(deadline) * 1e3),
      costs_(ladder_.size()),
      since_return_(kProven),
      to_return_(deadline),
      to_leave_out_(deadline),
      frames_at_(ladder_.size(), 0) {
  HDRCAM_CHECK(!ladder_.empty() && deadline > Duration::zero());
  while (at_ + 1 < ladder_.size() && ladder_[at_ + 1].emits_all()) ++at_;
  emits_all_ = at_;
}

FrameBudget Governor::next() const {
  const Rung& rung = ladder_[at_];
  FrameBudget budget = rung.budget;
  budget.emits = worked_on_ % rung.of < rung.emitted;
  return budget;
}

void Governor::done(const FrameWork& work, Backlog backlog) {
  backlog_ = backlog;
  times_.set_frames_queue(queues(backlog_));
  if (work.frames == 0) return;
  ++worked_on_;
  frames_at_[at_] += work.frames;
  if (work.frames > 1) return;  // the first frames come at once
  since_return_ = std::min(since_return_ + 1, kProven);
  pass_waits();
  add(work);
  if (is_hopeless())
    give_up();
  else if (const auto cheaper = rung_to_shed_to())
    shed_to(*cheaper);
  else if (const auto better = rung_to_return_to())
    return_to(*better);
}

void Governor::add(const FrameWork& work) {
  const int of = ladder_[at_].of;
  if (const auto mean = times_.add(work, of); mean && mean->total_ms > deadline_ms_) late_ += of;
  // Only frames in time are remembered: late ones tell more about the moment than about the rung.
  const bool window_is_new = times_.count() > 0 && times_.count() % kWindow == 0;
  if (window_is_new && times_.usual().total_ms <= deadline_ms_) remember();
}

// A return that held makes the next wait short again, and so does a machine that became faster. A rung whose
// wait is over counts as one that was never in use.
void Governor::pass_waits() {
  if (since_return_ == kProven && at_ <= blocked_) to_return_.shorten_next();
  if (to_return_.pass()) costs_.forget(blocked_);
  if (!to_leave_out_.is_over() && times_.is_full() && to_leave_out_.is_machine_faster(times_.steady_ms()))
    to_leave_out_.reset();
  to_leave_out_.pass();
}

// Whether not even the rung that leaves out most is in time: then frames are lost before they are worked on,
// and to leave out more gains nothing.
bool Governor::is_hopeless() const {
  if (at_ + 1 != ladder_.size() || at_ <= emits_all_ || times_.count() < kHopeless) return false;
  const FrameTime now = queues(backlog_) ? times_.mean() : times_.upper_quartile(kHopeless);
  return now.total_ms > deadline_ms_;
}

// All frames are emitted again, and for some time none is left out.
void Governor::give_up() {
  to_leave_out_.begin(times_.steady_ms());
  move_to(emits_all_);
}

// Sheds when the window is late, or at once when two frames in a row are very late: to the best rung that is
// expected to fit. Where none is, to the cheapest.
std::optional<std::size_t> Governor::rung_to_shed_to() const {
  const std::size_t end = rungs_in_use();
  if (at_ + 1 == end || times_.count() < kSudden || backlog_ == Backlog::None) return std::nullopt;
  const FrameTime newest = times_.upper_quartile(kSudden);
  const bool sudden = newest.total_ms > kSuddenlyLate * allowed_ms();
  // Frames of uneven cost wait for each other: none is left out before they are late in the mean.
  const double late_ms = at_ < emits_all_ ? times_.usual().total_ms : times_.mean().total_ms;
  const bool steady = times_.is_full() && late_ms > allowed_ms();
  if (!sudden && !steady) return std::nullopt;
  const FrameTime now = sudden ? newest : times_.usual();
  for (std::size_t r = at_ + 1; r < end; ++r) {
    const auto expected_ms = costs_.expected_ms(r, at_, now);
    if (!expected_ms || *expected_ms <= kRoomToShedTo * allowed_ms()) return r;
  }
  return end - 1;
}

// A rung that was returned to and turned out too slow before it had held is not tried again for some time.
void Governor::shed_to(std::size_t rung) {
  const bool failed = since_return_ < kProven;
  if (failed || !costs_.knows(at_)) remember();
  if (failed) {
    blocked_ = at_;
    to_return_.begin(times_.steady_ms());
  }
  since_return_ = kProven;
  move_to(rung);
}

// From the best one. Rungs that leave frames out are in use only where the wait after they were given up is
// over and no queue absorbs the late frames.
std::size_t Governor::rungs_in_use() const {
  const bool absorbs = queues(backlog_) && backlog_ != Backlog::Pressing;
  const bool emits_all = !to_leave_out_.is_over() || (absorbs && at_ <= emits_all_);
  return emits_all ? emits_all_ + 1 : ladder_.size();
}

// For a frame. A backlog that does not shrink by itself is worked off.
double Governor::allowed_ms() const {
  const bool catches_up = backlog_ == Backlog::Lasting || backlog_ == Backlog::Pressing;
  return deadline_ms_ * (catches_up ? kRoomToCatchUp : 1);
}

// Returns after a window on the present rung to the best rung that is known to fit, and tries one of unknown
// cost after fewer frames. No quality returns while frames wait.
std::optional<std::size_t> Governor::rung_to_return_to() const {
  const bool some_wait = queues(backlog_) && backlog_ != Backlog::None;
  if (at_ == 0 || times_.count() < kTrial || some_wait) return std::nullopt;
  if (times_.is_full())
    for (std::size_t r = 0; r < at_; ++r) {
      const double room = r == emits_all_ ? kRoomToEmitAll : room_to_return();
      const auto frame_ms = costs_.frame_ms(r, times_.steady_ms());
      if (frame_ms && !is_blocked(r) && *frame_ms <= room * deadline_ms_) return r;
    }
  return rung_to_try();
}

// The best rung of unknown cost that may fit, if each takes up to kMostStep times as long as the one below;
// of the next one it is enough that the present one leaves room.
std::optional<std::size_t> Governor::rung_to_try() const {
  const double room_ms = room_to_return() * deadline_ms_;
  double most_ms = times_.usual().total_ms;
  if (most_ms > room_ms) return std::nullopt;
  std::size_t best = at_;
  while (best > 0 && !costs_.knows(best - 1) && !is_blocked(best - 1)) {
    most_ms *= kMostStep;
    if (best < at_ && most_ms > room_ms) break;
    --best;
  }
  return best < at_ ? std::optional(best) : std::nullopt;
}

void Governor::return_to(std::size_t rung) {
  remember();
  since_return_ = 0;
  move_to(rung);
}

bool Governor::is_blocked(std::size_t rung) const {
  return rung <= blocked_ && !to_return_.is_over() && !to_return_.is_machine_faster(times_.steady_ms());
}

// A queue that is empty absorbs what is late.
double Governor::room_to_return() const {
  return backlog_ == Backlog::None ? kRoomBesideQueue : kRoomToReturn;
}

void Governor::remember() { costs_.remember(at_, times_.ratio()); }

void Governor::move_to(std::size_t rung) {
  at_ = rung;
  times_.restart();
}

}  // namespace hdrcam
