// The scores of a folder as JSON, for tables and scripts. Reentrant.
#pragma once

#include <string>

#include "render/scores/scores.h"

namespace hdrcam {

// What the scores of a folder are filed under: the last folder of the path, trailing slashes or not.
std::string folder_name(const std::string& path);

// Indented: psnr_mu, flicker.. in the units of ClipScores, null where not measured, and one object per frame.
std::string to_json(const ClipScores& scores, const std::string& clip, const std::string& label);

}  // namespace hdrcam
