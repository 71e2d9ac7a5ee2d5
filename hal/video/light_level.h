// The static metadata of HDR10 (SMPTE ST 2086 and CTA-861.3): as FFmpeg and x265 take them, and how the
// measured light level replaces the stated one in the header of a file. Reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/recording/libav.h"

namespace hdrcam {

// The display for which a stream was made: its colours lie within these primaries and this range.
struct MasteringDisplay {
  std::array<double, 2> red = {0.64, 0.33}, green = {0.30, 0.60}, blue = {0.15, 0.06},
                        white = {0.3127, 0.3290};  // CIE 1931 xy; Rec. ITU-R BT.709, D65
  double black_nits = 0.005, peak_nits = 1000;
};

struct LightLevel {
  int most_nits = 1;       // MaxCLL: of the brightest pixel, 1..10000
  int most_mean_nits = 1;  // MaxFALL: mean of the brightest frame
};

// Adds both to the stream's side data, from which the muxer takes them.
void add_to(AVStream& stream, const MasteringDisplay& display, const LightLevel& level);

// "hdr10=1:cll=0:master-display=..", which puts the display into the stream's own headers. The light level is
// not repeated there: each second of the stream would state it before it is known.
std::string x265_parameters(const MasteringDisplay& display);

// A few bytes of a file that are to be others.
struct BytePatch {
  std::size_t offset = 0;
  std::vector<std::uint8_t> bytes;
};

// header: of an MP4, MOV or Matroska file that states `stated`. None of the patches changes a length.
std::vector<BytePatch> light_level_patches(std::span<const std::uint8_t> header, const LightLevel& stated,
                                           const LightLevel& level);

}  // namespace hdrcam
