// Dropped frames: the sensor exposes them, but they are not delivered. Each frame is lost with the same
// probability, independently of the others. Value type, reentrant.
#pragma once

#include <cstdint>

#include "hal/sim/counter_random.h"

namespace hdrcam {

struct DropSettings {
  double probability = 0.02;  // of each frame
};

class Drops {
 public:
  Drops(DropSettings settings, std::uint64_t seed)
      : probability_(settings.probability), random_(seed, 0x64726f70) {}
  bool lost(std::uint64_t sequence) const { return random_.uniform(sequence) < probability_; }

 private:
  double probability_;
  CounterRandom random_;
};

}  // namespace hdrcam
