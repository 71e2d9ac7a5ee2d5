// Holds a run's deadline per frame: from the times of the frames so far it chooses the rung of the ladder
// (budget_ladder.h) for the next one. Its rules, and their constants here and in governor.cpp:
//   start     the cheapest rung that emits every frame, so that the first frames come early
//   judge     a rung by the upper quartile of its last kWindow frames, or by their mean where a queue evens
//             out what is uneven: frames whose long exposure is clipped take half as long again
//   predict   a rung takes what it took when it was last in use, in units of the work that no rung changes:
//             a machine that is slowed by other work slows both alike. One that was never in use is taken to
//             lie between its neighbours when time is short
//   shed      when the last kWindow frames are late, or at once when kSudden in a row exceed kSuddenlyLate;
//             to the best rung that is predicted to fit within kRoomToShedTo
//   return    after kWindow frames to the best rung that is predicted to fit within kRoomToReturn; to the
//             one of the start within kRoomToEmitAll
//   try       after kTrial frames, where there is ample time, a rung that was never in use; several at once
//             where all fit at kMostStep times the one below
//   wait      a rung that turned out too slow before it held for kProven frames is tried again after
//             kFirstWait_s, each time twice as long up to kLongestWait of these, or when the machine became
//             faster (kFasterMachine)
//   give up   where not even the last rung is in time, frames are lost before they are worked on, and to
//             leave out more gains nothing: back to the rung of the start, for such a wait
//   queue     where frames queue (backlog.h), it knows better than times tell whether the run keeps up: none
//             is left out for late frames that the queue absorbs, none of quality returns while frames wait,
//             it returns within kRoomBesideQueue while none does, and a backlog that does not shrink is
//             worked off within kRoomToCatchUp
// Deterministic: times in, budget out; it reads no clock. No allocation after the constructor. Thread-bound.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "firmware_host/run/backlog.h"
#include "firmware_host/run/budget_ladder.h"
#include "hal/core/instant.h"

namespace hdrcam {

// The time of the work on one frame, or of one call that did several frames at once (the first ones).
struct FrameWork {
  int frames = 0;        // 0: the call only stored its frame
  double total_ms = 0;   // all of it
  double steady_ms = 0;  // the part of it that is the same on every rung, for the same frame
};

class Governor {
 public:
  // ladder: at least one rung.
  Governor(std::vector<Rung> ladder, Duration deadline);

  // The budget of the next frame. Call it once per frame.
  FrameBudget next();
  // How long that frame took, and what waits behind it.
  void done(const FrameWork& work, Backlog backlog = Backlog::Unknown);

  int rung() const { return static_cast<int>(at_); }  // of the next frame
  const std::vector<Rung>& ladder() const { return ladder_; }
  bool previews() const { return ladder_[at_].previews; }
  Duration deadline() const { return deadline_; }
  double deadline_ms() const { return deadline_ms_; }
  int late() const { return late_; }  // frames over the deadline; of those with one emission, their mean
  // Frames at each rung.
  const std::vector<int>& frames_at() const { return frames_at_; }

 private:
  // The last few frames on the present rung.
  static constexpr std::size_t kWindow = 8, kTrial = 5, kSudden = 2;

  struct Sample {
    double total_ms = 0, steady_ms = 0;
    double ratio() const { return total_ms / steady_ms; }
  };
  // Until when something that turned out too slow is not tried again. Each wait is twice the one before.
  struct Wait {
    int frames_left = 0;
    int next = 0;          // frames, of the next wait
    double steady_ms = 0;  // of the machine when it began
  };

  void add(const FrameWork& work);
  Sample upper(std::size_t newest) const;
  Sample mean() const;
  Sample usual() const;
  double steady_ms() const;
  void begin(Wait& wait) const;
  bool is_faster_than_in(const Wait& wait) const;
  bool is_blocked(std::size_t rung) const;
  std::size_t end() const;
  double room_to_return() const;
  double allowed_ms() const;
  std::optional<std::size_t> rung_to_shed_to() const;
  std::optional<double> expected_ratio(std::size_t rung, double present) const;
  std::optional<std::size_t> rung_to_return_to() const;
  std::optional<std::size_t> rung_to_try() const;
  void remember();
  void shed_to(std::size_t rung);
  void move_to(std::size_t rung);
  void pass_waits();
  bool is_hopeless() const;
  void give_up();

  const std::vector<Rung> ladder_;
  const Duration deadline_;
  const double deadline_ms_;
  const int first_wait_;  // frames
  std::size_t at_ = 0;
  std::vector<std::optional<double>>
      ratios_;                            // by rung: total over steady, when it was last in use; none: never
  std::array<Sample, kWindow> window_{};  // a ring
  std::size_t samples_ = 0;               // since the rung changed
  int unsettled_ = 0;                     // frames after a change that are not counted
  Sample pending_;                        // of a group of frames of which one is emitted
  int pending_frames_ = 0;
  int since_return_ = 0;       // frames; large where the last change was to shed
  std::size_t blocked_ = 0;    // a rung that was too slow; better ones are blocked with it
  Wait to_return_;             // to those
  std::size_t emits_all_ = 0;  // the cheapest rung that does
  Wait to_leave_out_;          // frames: the rungs below that one were not in time either
  Backlog backlog_ = Backlog::Unknown;
  long frames_ = 0;
  int late_ = 0;
  std::vector<int> frames_at_;
};

}  // namespace hdrcam
