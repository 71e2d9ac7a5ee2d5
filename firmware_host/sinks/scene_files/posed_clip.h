// The pictures of a run or of a recording with their camera: what files for reconstruction tools are written
// from. Camera axes x right, y down, z forward; pixel centres at +0.5; lengths in `length_unit`. Plain value,
// reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "online/priors/pose/frame_pose.h"

namespace hdrcam {

struct PosedPicture {
  std::string path;                       // of the picture, as the user would name it
  std::string depth_path;                 // of its depth (depth_pictures.h); "" for none
  double time_s = 0;                      // since the first frame
  std::optional<double> exposure_s = {};  // none where only ratios of exposures are known
  RigidTransform T_world_camera;
  int world = 0;  // FramePose::world
};

struct ColouredPoint {
  Eigen::Vector3d p_world;
  std::array<std::uint8_t, 3> rgb{};  // sRGB
  std::size_t picture = 0;            // of PosedClip::pictures, that saw it..
  double u_px = 0, v_px = 0;          // ..here
};

struct PosedClip {
  int width = 0, height = 0;  // of every picture, pixels
  Intrinsics lens;
  bool lens_is_assumed = false;  // only where poses were tracked, with this very lens
  PoseSource source = PoseSource::Given;
  std::vector<PosedPicture> pictures;
  std::vector<ColouredPoint> points;
  int left_out = 0;  // frames without a pose that can be used

  LengthUnit length_unit() const { return unit_of(source); }
};

// With the time and the exposure of its frame. start: of the first frame.
PosedPicture posed_picture(std::string path, const FrameFacts& facts, Instant start,
                           const RigidTransform& T_world_camera);

// The path as seen from a folder: "../out/000000.png". Both are relative to the working directory, or
// absolute.
std::string path_from(const std::string& folder, const std::string& path);

// Given poses need the lens that they were made with. Invalid, saying what to do, where `lens` is only
// assumed. clip: what the message names.
Result<void> check_lens(PoseSource source, bool lens_is_assumed, const std::string& clip);

}  // namespace hdrcam
