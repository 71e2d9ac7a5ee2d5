// Whether pictures of 16 bits a sample hold codes of fewer bits in the lower ones, as some programs write
// them: such frames are nearly black. Thread-bound.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "hal/core/frame.h"

namespace hdrcam {

class LowCodes {
 public:
  explicit LowCodes(const CameraFacts& camera) : camera_(camera) {}

  // Frames in order.
  void observe(const Image<std::uint16_t>& codes);
  // A sentence without a full stop, or "". A dark scene of 16 bits has codes as low, but is not clipped at
  // the largest code of fewer bits: a frame has to be, and no code of any frame may be above it.
  std::string warning() const;
  // Of frames that cannot be told apart: the warning, or else what so low codes may be. A sensor may clip
  // below its largest code.
  std::string suspicion() const;

 private:
  static constexpr int kFewest = 9, kMost = 14;  // bits that sensors have

  const CameraFacts camera_;
  std::uint16_t brightest_ = 0;
  std::uint64_t frames_ = 0;
  struct Clipped {
    double share = 0;         // of the samples of a frame: the largest of all frames
    std::uint64_t frame = 0;  // its place
  };
  std::array<Clipped, kMost - kFewest + 1> clipped_{};  // at the largest code of 9 .. 14 bits
};

}  // namespace hdrcam
