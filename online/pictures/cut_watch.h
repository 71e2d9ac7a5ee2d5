// Tells at which frame of a stream another scene begins: a cut. What was carried from frame to frame then is
// of another place. Each frame is compared with the newest one before it that shows enough (same_scene.h). No
// allocation after the first frame. Thread-bound.
#pragma once

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
  SceneThumbnail small(const ExposedFrame& frame);
  void keep(const SceneThumbnail& now);

  SceneThumbnail seen_{};  // of the newest frame of this scene that shows enough to compare
  int age_ = 0;            // frames since that one
  std::vector<float> scratch_;
};

}  // namespace hdrcam
