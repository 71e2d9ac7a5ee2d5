// The strobe line as pulses, found by the time of their frames: a sensor answers each exposure with one, and
// the kernel stamps its edges. Pulses are counted, so that the pulses of two frames say how many frames lie
// between them. Thread-bound; bounded state, no allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/camera.h"
#include "hal/sync_line.h"

namespace hdrcam {

// What a pulse of the strobe line marks on this sensor.
enum class StrobePulse { Absent, MarksFrame, SpansExposure };

class StrobePulses {
 public:
  struct Pulse {
    std::uint64_t number = 0;  // pulses before it
    Instant rise;
    std::optional<Duration> width;  // none where its end was not seen
  };

  // after_timestamp: of the rising edge, or of the falling one where the pulse spans the exposure and the
  // timestamp marks its end.
  StrobePulses(StrobePulse kind, Duration after_timestamp, TimestampMark mark)
      : kind_(kind),
        after_timestamp_(after_timestamp),
        by_end_(kind == StrobePulse::SpansExposure && mark == TimestampMark::ExposureEnd) {}

  // Adds an edge of the line, in order.
  void add(const Edge& edge);
  // The pulse whose edge is nearest to the time expected for a frame with this timestamp, and no further from
  // it than `within`.
  std::optional<Pulse> pulse_of(Instant timestamp, Duration within) const;
  // Whether a frame with this timestamp is older than all pulses that are kept, and there were others.
  bool forgot(Instant timestamp) const;

  // Pulses from the last frame's to this one; 0 where either frame has none, or an edge between was lost.
  std::int64_t since_last(const std::optional<Pulse>& pulse) const;
  // Notes the pulse of the next frame, or that it has none.
  void matched(const std::optional<Pulse>& pulse);

 private:
  // A reader that is late brings all pulses that waited before the first of their frames.
  static constexpr std::size_t kKept = SyncLine::kMostWaiting / 2;

  std::optional<Instant> marked_edge(const Pulse& pulse) const;

  StrobePulse kind_;
  Duration after_timestamp_;
  bool by_end_;                        // falling edges are matched
  std::array<Pulse, kKept> pulses_{};  // the n-th at n % kKept
  std::uint64_t count_ = 0, edge_sequence_ = 0;
  bool line_high_ = false;
  std::optional<std::uint64_t> last_;  // number of the last frame's
};

}  // namespace hdrcam
