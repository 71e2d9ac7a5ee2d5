// Whether two pictures of different exposure show one scene, or a cut lies between them. Whatever lies
// between the exposures and whatever the response, two pictures of one scene agree in the medians of 16x16
// cells of green up to a monotone curve, so Spearman's rank correlation of these is compared with a limit.
// Reentrant.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "capture/exposed_frame.h"

namespace hdrcam {

// What is compared of a picture, for those who keep it for later: a median per cell, -1 where it is clipped.
constexpr int kThumbnailCells = 16;  // along each side
using SceneThumbnail = std::array<float, std::size_t{kThumbnailCells} * kThumbnailCells>;
// every_line: n, each n-th line is looked at. scratch: its memory is used again.
SceneThumbnail thumbnail_of(const ExposedFrame& frame, int every_line, std::vector<float>& scratch);

// That correlation, -1..1, over the cells that are clipped in neither picture; 1 when fewer than so many are
// left.
double scene_agreement(const SceneThumbnail& a, const SceneThumbnail& b, std::size_t fewest_cells);

// Both of one size. True also where too few cells are clipped in neither picture to tell.
bool shows_one_scene(const ExposedFrame& a, const ExposedFrame& b);

}  // namespace hdrcam
