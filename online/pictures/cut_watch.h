// Tells at which frame of a stream another scene begins: a cut. What was carried from frame to frame then is
// of another place. Each frame is compared with the newest one before it that shows enough (same_scene.h),
// and with the newest of about its own exposure, which shows the same part of a scene: a short exposure and a
// long one may have but dark corners in common. No allocation after the first frame. Thread-bound.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "online/pictures/same_scene.h"

namespace hdrcam {

class CutWatch {
 public:
  // The first frame of a stream, or of what is known to be another scene.
  void begin(const ExposedFrame& frame);
  // A later one: whether another scene begins with it, which later ones are then compared with.
  bool ends_before(const ExposedFrame& frame);

 private:
  static constexpr int kTwoRounds = 8;  // frames, of a long cycle
  struct Seen {
    float exposure = 1;
    SceneThumbnail thumbnail{};
  };

  void begin(const Seen& first);
  const Seen* newest_of(float exposure) const;  // null: none lately
  void keep(const Seen& now);

  Seen telling_;                         // the newest frame of this scene that shows enough to compare
  int age_ = 0;                          // frames since that one
  std::array<Seen, kTwoRounds> recent_;  // that show enough, of this scene
  std::size_t count_ = 0;                // of these, so far
  std::vector<float> scratch_;
};

}  // namespace hdrcam
