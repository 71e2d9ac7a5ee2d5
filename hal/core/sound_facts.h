// Checks whether facts from a file or a setting are possible for a camera, and the limits that more than one
// check has. objection_to() returns nullopt, or a clause that names the wrong value and what is wrong, to
// follow "frame 3: ". Reentrant.
#pragma once

#include <optional>
#include <string>

#include "hal/core/frame.h"

namespace hdrcam {

// Sides of a picture; the FFV1 of FFmpeg 5.1 loses pictures of one line.
constexpr int kMinSidePx = 2, kMaxSidePx = 16384;
constexpr bool is_possible_side(int side_px) { return side_px >= kMinSidePx && side_px <= kMaxSidePx; }
// Of a time stamp, from the clock's zero; differences of two in nanoseconds still fit 64 bits.
constexpr double kLatest_s = 4e9;
// Of a frame's exposure, analogue and digital alike.
constexpr double kMostExposureGain = 1e6;

// False for NaN.
constexpr bool is_within(double value, double least, double most) { return value >= least && value <= most; }

// Focal lengths of 1 to 1e6 pixels; a principal point within ten pictures of this one.
std::optional<std::string> objection_to(const Intrinsics& lens, int width_px, int height_px);

// A rotation (orthonormal to 1 %, right-handed) and a place within 1e7 metres.
std::optional<std::string> objection_to(const PoseMatrix& T_world_camera);

// Gains of a white balance, 1/64 to 64.
std::optional<std::string> objection_to(const ChannelGains& gains);

// What can be filmed at all: the lens, the white balance, 0.001 to 100000 frames a second, and a response,
// where one is stated, of three curves of 256 exposures, 0 to 1e12, that never fall and end above 0.
std::optional<std::string> objection_to(const CameraFacts& camera);

// The frame's own pose and black level (0 to below the largest code), an exposure of at most a day and gains
// of at most 1e6, none negative (NaN is unknown), a time within 126 years of the clock's zero, and its number
// and time after those of the frame before it.
std::optional<std::string> objection_to(const FrameFacts& facts, const FrameFacts* before);

}  // namespace hdrcam
