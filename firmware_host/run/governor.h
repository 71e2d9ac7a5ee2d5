// Holds a run's deadline per frame: from the times of the frames so far it chooses the rung of the ladder
// (budget_ladder.h) for the next one. It starts on the cheapest rung that emits every frame, so that the
// first frames come early. After each frame it may give up leaving frames out, shed to a cheaper rung or
// return to a better one (governor.cpp). Deterministic: times in, budget out; it reads no clock. No
// allocation after the constructor. Thread-bound.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "firmware_host/run/backlog.h"
#include "firmware_host/run/backoff.h"
#include "firmware_host/run/budget_ladder.h"
#include "firmware_host/run/frame_work.h"
#include "firmware_host/run/rung_costs.h"
#include "firmware_host/run/rung_times.h"
#include "hal/core/instant.h"

namespace hdrcam {

class Governor {
 public:
  // ladder: at least one rung.
  Governor(std::vector<Rung> ladder, Duration deadline);

  // The budget of the next frame.
  FrameBudget next() const;
  // How long that frame took, and what waits behind it. Call it once per frame; one that has no part in the
  // fit is none of the frames of which a rung emits some.
  void done(const FrameWork& work, Backlog backlog = Backlog::Unknown);
  // So many frames waited for later ones until the end; they count at the present rung.
  void ended(int frames) { frames_at_[at_] += frames; }

  int rung() const { return static_cast<int>(at_); }  // of the next frame
  const std::vector<Rung>& ladder() const { return ladder_; }
  bool previews() const { return ladder_[at_].previews; }
  Duration deadline() const { return deadline_; }
  double deadline_ms() const { return deadline_ms_; }
  int late() const { return late_; }  // frames over the deadline; of those with one emission, their mean
  // Frames at each rung.
  const std::vector<int>& frames_at() const { return frames_at_; }

 private:
  void add(const FrameWork& work);
  void pass_waits();

  bool is_hopeless() const;
  void give_up();

  std::optional<std::size_t> rung_to_shed_to() const;
  void shed_to(std::size_t rung);
  std::size_t rungs_in_use() const;
  double allowed_ms() const;

  std::optional<std::size_t> rung_to_return_to() const;
  std::optional<std::size_t> rung_to_try() const;
  void return_to(std::size_t rung);
  bool is_blocked(std::size_t rung) const;
  double room_to_return() const;

  void remember();
  void move_to(std::size_t rung);

  const std::vector<Rung> ladder_;
  const Duration deadline_;
  const double deadline_ms_;
  std::size_t at_ = 0;
  std::size_t emits_all_ = 0;  // the cheapest rung that does
  RungTimes times_;            // on the present rung
  RungCosts costs_;
  int since_return_;         // frames; large where the last change was to shed
  std::size_t blocked_ = 0;  // a rung that was too slow; better ones are blocked with it
  Backoff to_return_;        // to those
  Backoff to_leave_out_;     // frames: not even that was in time
  Backlog backlog_ = Backlog::Unknown;
  long worked_on_ = 0;  // frames; the first ones, which come at once, are one
  int late_ = 0;
  std::vector<int> frames_at_;
};

}  // namespace hdrcam
