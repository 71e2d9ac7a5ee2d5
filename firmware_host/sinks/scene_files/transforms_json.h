// transforms.json, as nerfstudio and instant-ngp read it: the pictures of a clip, their camera-to-world
// matrices and one lens. Its cameras have OpenGL's axes (x right, y up, looking along -z), so the columns y
// and z of ours are negated; the world stays ours. Pixels are measured from the corner of the picture, as
// ours. Depth is in thousandths of the unit of length, nerfstudio's default for 16-bit pictures.
// Source: docs.nerf.studio/quickstart/data_conventions.html. Reentrant.
#pragma once

#include <string>

#include "firmware_host/sinks/scene_files/posed_clip.h"

namespace hdrcam {

// folder: in which the file will be; its pictures are named from there.
std::string to_transforms_json(const PosedClip& clip, const std::string& folder);

}  // namespace hdrcam
