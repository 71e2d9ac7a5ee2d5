// The cycle of exposures that a camera walks through, as data: request n gets slot n mod slots. Made once,
// checked against what the sensor offers, then immutable. Value type, reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "capture/exposure.h"

namespace hdrcam {

// Lamps on the mains pulse at twice its frequency: an exposure of whole half periods sees the same light
// every time.
enum class Mains { Off, Hz50, Hz60 };

// Half a mains period; zero for Off.
Duration half_period(Mains mains);

class ExposureSchedule {
 public:
  static constexpr int kMaxSlots = 4;

  struct Slot {
    Exposure asked;         // by the user
    Exposure exposure;      // that the sensor can do: whole lines, whole gain codes, whole mains half periods
    bool flickers = false;  // shorter than a mains half period: will pulse under lamps
  };

  // Exposures of at least a mains half period are moved to the nearest multiple that fits the frame, shorter
  // ones are kept and flagged. Errors: Invalid for no slot or more than four; BadExposure for what the sensor
  // does not offer, or for an exposure that does not fit the frame duration, saying which one would do.
  static Result<ExposureSchedule> create(std::span<const Exposure> cycle, const CameraCapabilities& camera,
                                         Duration frame_duration, Mains mains = Mains::Off);

  // Of a camera that sets its exposures itself: taken as they are. Invalid for no slot or more than four.
  static Result<ExposureSchedule> observed(std::span<const Exposure> cycle);

  // The time that a sensor needs in a frame besides its exposure.
  static Duration frame_margin(const CameraCapabilities& camera);

  int slots() const { return count_; }
  const Slot& slot(int index) const { return slots_[static_cast<std::size_t>(index)]; }
  int slot_of(std::uint64_t request) const {
    return static_cast<int>(request % static_cast<std::uint64_t>(count_));
  }
  // The one whose product is nearest; -1 where several slots share it.
  int nearest_slot(const Exposure& exposure) const;
  const Exposure& exposure_of(std::uint64_t request) const { return slot(slot_of(request)).exposure; }

  // Of the longest exposure, with the sensor's margin.
  Duration shortest_frame_duration() const { return shortest_frame_duration_; }
  // Geometric mean of the products, seconds x gain: E_ref of a clip taken with this cycle.
  double reference_exposure() const;

 private:
  std::array<Slot, kMaxSlots> slots_{};
  int count_ = 0;
  Duration shortest_frame_duration_{0};
};

}  // namespace hdrcam
