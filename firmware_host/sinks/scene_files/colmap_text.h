// A sparse model in COLMAP's text format: cameras.txt, images.txt, points3D.txt. Its cameras have our axes (x
// right, y down, z forward) and its pixels our origin (the centre of the first pixel is (0.5, 0.5)); a pose
// is world-to-camera, as quaternion QW QX QY QZ and translation. Each point has a track of one: the picture
// whose depth it is from. Its reprojection error is -1, COLMAP's word for unknown. Source:
// colmap.github.io/format.html. Reentrant.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "firmware_host/sinks/scene_files/posed_clip.h"
#include "hal/storage.h"

namespace hdrcam {

inline constexpr std::array<std::string_view, 3> kColmapFiles = {"cameras.txt", "images.txt", "points3D.txt"};

// Writes the files into `model`, which it makes. folder: COLMAP's --image_path, from which pictures are
// named. Errors: those of the disk.
Result<void> write_colmap(Storage& storage, const std::string& model, const PosedClip& clip,
                          const std::string& folder);

}  // namespace hdrcam
