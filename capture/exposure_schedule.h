// The cycle of exposures of a camera: request n gets slot n mod slots. It is checked against the sensor's
// capabilities when it is created, then immutable. Value type, reentrant.
#pragma once

#include <cstdint>
#include <span>

#include "capture/exposure.h"
#include "hal/core/inline_list.h"

namespace hdrcam {

// Mains frequency (anti-flicker). Lamps flicker at twice the mains frequency, so an exposure of whole half
// periods always collects the same light.
enum class Mains { Off, Hz50, Hz60 };

// Half a mains period; zero for Off.
Duration half_period(Mains mains);
// Whether an exposure lasts at least so long, but for its rounding to the sensor's lines.
bool lasts(Duration exposure, Duration half_period);
// The nearest time of whole half periods, as many as `longest` holds, at least one.
Duration whole_half_periods(Duration time, Duration half_period, Duration longest);

// Invalid for no slot or more than four.
Result<void> check_slots(std::span<const Exposure> cycle);
// Invalid for a cycle of several exposures that are all the same: the proof cannot tell them apart, and they
// give no HDR.
Result<void> check_distinct(std::span<const Exposure> cycle);

// The longest time within this one that describe() prints in full, so that a user can type it.
Duration rounded_down(Duration longest);

class ExposureSchedule {
 public:
  static constexpr int kMaxSlots = 4;
  using Cycle = InlineList<Exposure, kMaxSlots>;

  struct Slot {
    Exposure asked;         // by the user
    Exposure exposure;      // rounded to whole lines, gain codes and mains half periods
    bool flickers = false;  // shorter than a mains half period: flickers under lamps
  };

  // Exposures of at least a mains half period are moved to the nearest multiple that fits the frame, shorter
  // ones are kept and flagged. Errors: Invalid for no slot or more than four, or where they become the same
  // (check_distinct); BadExposure outside the sensor's range, or for an exposure too long for the frame,
  // naming one that fits, and a rate where the sensor can expose that long.
  static Result<ExposureSchedule> create(std::span<const Exposure> cycle, const CameraCapabilities& camera,
                                         Duration frame_duration, Mains mains = Mains::Off);

  // For a camera that sets its own exposures, not rounded. Invalid for no slot or more than four.
  static Result<ExposureSchedule> observed(std::span<const Exposure> cycle);

  // The part of the frame duration that the exposure cannot use (read-out).
  static Duration frame_margin(const CameraCapabilities& camera);

  int slots() const { return static_cast<int>(slots_.size()); }
  const Slot& slot(int index) const { return slots_[static_cast<std::size_t>(index)]; }
  int slot_of(std::uint64_t request) const { return static_cast<int>(request % slots_.size()); }
  // The slot whose product is nearest; -1 where several slots share it.
  int nearest_slot(const Exposure& exposure) const;
  const Exposure& exposure_of(std::uint64_t request) const { return slot(slot_of(request)).exposure; }
  Cycle cycle() const;  // the exposures of all slots

 private:
  InlineList<Slot, kMaxSlots> slots_;
};

}  // namespace hdrcam
