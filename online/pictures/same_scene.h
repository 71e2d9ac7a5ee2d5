// Whether two pictures of different exposure show one scene, or a cut lies between them. Whatever lies
// between the exposures and whatever the response, two pictures of one scene agree in the medians of 16x16
// cells of a channel up to a monotone curve, so Spearman's rank correlation of these is compared with a
// limit: the mean over the channels, in which one counts by how far its cells differ in the picture where
// they differ less, because a dark picture may have nothing but noise in some of them. Reentrant.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "capture/exposed_frame.h"

namespace hdrcam {

// What is compared of a picture, for those who keep it for later: per channel a median of each cell, -1 where
// that is clipped.
constexpr int kThumbnailCells = 16;  // along each side
using ThumbnailChannel = std::array<float, std::size_t{kThumbnailCells} * kThumbnailCells>;
using SceneThumbnail = std::array<ThumbnailChannel, 3>;
// every_line: n, each n-th line is looked at. scratch: its memory is used again.
SceneThumbnail thumbnail_of(const ExposedFrame& frame, int every_line, std::vector<float>& scratch);
// The same of 64 lines and more, which are enough where pictures go by one after the other: below a
// millisecond at 640x480.
SceneThumbnail quick_thumbnail_of(const ExposedFrame& frame, std::vector<float>& scratch);

// That correlation, -1..1, over the cells that are clipped in neither picture. A channel that has fewer than
// `fewest_cells` of them, or but one code, counts as 1 and little. presumed: as if so many codes by which
// cells differ had been seen to agree.
double scene_agreement(const SceneThumbnail& a, const SceneThumbnail& b, std::size_t fewest_cells,
                       double presumed = 0);

// Whether some channel has so many cells that are not clipped and differ by more than noise.
bool shows_scene(const SceneThumbnail& thumbnail, std::size_t fewest_cells);

// Both of one size. True also where too few cells are clipped in neither, or all of one are equal.
bool shows_one_scene(const ExposedFrame& a, const ExposedFrame& b);

}  // namespace hdrcam
