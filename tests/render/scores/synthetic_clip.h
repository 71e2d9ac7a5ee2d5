// A small clip with ground truth, and an estimate of it with known faults, the same on every machine: 48x36,
// eight frames, three exposures. A textured background moves by (1.5, 0.5) px a frame; a brighter square,
// object 1, by (-1, 2) px before it; one lamp is far above white.
#pragma once

#include <string>

#include "hal/core/image.h"

namespace hdrcam::synthetic_clip {

inline constexpr int kRows = 36, kCols = 48, kFrames = 8;
inline constexpr float kDepthScale = 0.25f;  // of the estimate's depth, 3 % off on the square

// [rgb, rows, cols], and [1, rows, cols] metres, and [dx dy occluded, rows, cols] to the next frame
Image<float> radiance(int frame);
Image<float> depth(int frame);
Image<float> flow(int frame);
// The estimate of an imperfect method: gains, noise, pumping, a ghost behind the square.
Image<float> estimate(int frame);

// Writes clip.json and gt/ into the folder, which must not be a clip yet.
void write_clip(const std::string& folder);
enum class Geometry { Without, With };
// Writes one estimated frame: radiance, and with geometry depth and both flows, too.
void write_estimate(const std::string& path, int frame, Geometry geometry);

// A scratch folder of its own.
class TemporaryFolder {
 public:
  TemporaryFolder();

  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  const std::string path_;
};

}  // namespace hdrcam::synthetic_clip
