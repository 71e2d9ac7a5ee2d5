// A clip with ground truth: CLIP/clip.json and the pictures under CLIP/gt, one per frame and kind, read on
// demand. Only scoring reads gt/; the pipeline never does. Thread-bound; it owns only the facts and returns
// new images.
//   gt/gt.json        r_sat_shortest (radiance that saturates the shortest exposure), moving_ids (optional)
//   gt/hdr/NNNN.exr   R G B radiance                         gt/depth/NNNN.exr  camera z, metres (optional)
//   gt/flow/NNNN.exr  R=dx G=dy to the next frame, pixels; B=1 where occluded there (optional)
//   gt/id/NNNN.png    object ids, 8 bit (optional)
//   gt/novel/NNNN.exr R G B radiance from the camera novel_c2w of gt.json, of some frames (optional)
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/recording/recording.h"
#include "hal/storage.h"

namespace hdrcam {

// Where each pixel of a frame is in the next one. Empty images where the clip has no flow.
struct MotionTruth {
  Image<float> flow;               // [dx dy, rows, cols] pixels
  Image<std::uint8_t> comparable;  // [1, rows, cols] 1 where the pixel is visible in the next frame
};

// The camera of a frame, and another one at the same moment.
struct PosePair {
  PoseMatrix T_world_own, T_world_novel;  // metres
};

class GroundTruth {
 public:
  // Errors: NotFound (no clip.json, no gt), Corrupt (their content), BadExposure.
  static Result<GroundTruth> open(Storage& storage, const std::string& clip_folder);

  int frames() const { return static_cast<int>(exposures_.size()); }
  int rows() const { return rows_; }
  int cols() const { return cols_; }
  // Seconds x gains.
  double exposure(int frame) const { return exposures_[static_cast<std::size_t>(frame)]; }
  // The number of its HDR frame: the sensor's counter where the clip states it (a gap is a dropped frame),
  // otherwise the frame's position in the clip.
  std::uint64_t number(int frame) const { return numbers_[static_cast<std::size_t>(frame)]; }
  // Seconds from the first frame, and between frames of neighbouring numbers; NaN where the clip states no
  // times.
  double time_s(int frame) const { return times_s_[static_cast<std::size_t>(frame)] - times_s_.front(); }
  double interval_s() const;
  double shortest_saturation() const { return shortest_saturation_; }

  // Each reads one picture of a frame in [0, frames()). Errors: those of read_exr; SizeChanged; Corrupt where
  // radiance or motion is not finite. The optional kinds are empty images where the clip has none.
  Result<Image<float>> radiance(int frame) const;  // [rgb, rows, cols] finite
  Result<MotionTruth> motion(int frame) const;
  Result<Image<float>> depth(int frame) const;               // [1, rows, cols] metres
  Result<Image<std::uint8_t>> moving_mask(int frame) const;  // [1, rows, cols] 1 on moving objects
  Result<Image<float>> novel_radiance(int frame) const;      // [rgb, rows, cols] as another camera sees it
  const std::optional<PosePair>& novel_camera(int frame) const {
    return novel_cameras_[static_cast<std::size_t>(frame)];
  }

 private:
  GroundTruth(Storage& storage, std::string folder) : storage_(&storage), folder_(std::move(folder)) {}
  std::string path(const char* kind, int frame, const char* extension) const;
  Result<void> read_facts();

  Storage* storage_;
  std::string folder_;
  int rows_ = 0, cols_ = 0;
  std::vector<double> exposures_;
  std::vector<std::uint64_t> numbers_;
  std::vector<double> times_s_;                         // as stated
  std::vector<std::optional<PosePair>> novel_cameras_;  // of each frame
  double shortest_saturation_ = 0;
  std::array<bool, 256> moving_ids_{};
  bool anything_moves_ = false;
};

}  // namespace hdrcam
