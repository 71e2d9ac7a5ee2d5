extern "C" {
#include <libavutil/mastering_display_metadata.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/video/light_level.h"

namespace hdrcam {
namespace {

constexpr int kChromaticityUnits = 50000, kLuminanceUnits = 10000;  // per 1 and per cd/m2, SMPTE ST 2086

AVRational chromaticity(double xy) {
  return {static_cast<int>(std::lround(xy * kChromaticityUnits)), kChromaticityUnits};
}
AVRational luminance(double nits) {
  return {static_cast<int>(std::lround(nits * kLuminanceUnits)), kLuminanceUnits};
}

using Bytes = std::vector<std::uint8_t>;

std::uint8_t high(int value) { return static_cast<std::uint8_t>(value >> 8); }
std::uint8_t low(int value) { return static_cast<std::uint8_t>(value & 0xff); }

// What is looked for, and how much of it comes before the bytes that change.
struct Pattern {
  Bytes found;
  std::size_t before;
  Bytes replacement;
};

Pattern pattern(Bytes before, const Bytes& stated, Bytes replacement) {
  const std::size_t length = before.size();
  before.insert(before.end(), stated.begin(), stated.end());
  return {std::move(before), length, std::move(replacement)};
}

Bytes both(const LightLevel& level) {
  return {high(level.most_nits), low(level.most_nits), high(level.most_mean_nits), low(level.most_mean_nits)};
}

// Matroska writes a number with as many bytes as it needs.
Pattern matroska_element(std::uint8_t id, int stated, int value) {
  if (stated < 256) return pattern({0x55, id, 0x81}, {low(stated)}, {low(value)});
  return pattern({0x55, id, 0x82}, {high(stated), low(stated)}, {high(value), low(value)});
}

}  // namespace

void add_to(AVStream& stream, const MasteringDisplay& display, const LightLevel& level) {
  AVMasteringDisplayMetadata* mastering = libav::allocated(av_mastering_display_metadata_alloc());
  const std::array<double, 2>* const primaries[] = {&display.red, &display.green, &display.blue};
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < 2; ++i) mastering->display_primaries[c][i] = chromaticity((*primaries[c])[i]);
  for (std::size_t i = 0; i < 2; ++i) mastering->white_point[i] = chromaticity(display.white[i]);
  mastering->min_luminance = luminance(display.black_nits);
  mastering->max_luminance = luminance(display.peak_nits);
  mastering->has_primaries = mastering->has_luminance = 1;
  libav::add_side_data(stream, AV_PKT_DATA_MASTERING_DISPLAY_METADATA, mastering, sizeof *mastering);

  std::size_t size = 0;
  AVContentLightMetadata* light = libav::allocated(av_content_light_metadata_alloc(&size));
  light->MaxCLL = static_cast<unsigned>(level.most_nits);
  light->MaxFALL = static_cast<unsigned>(level.most_mean_nits);
  libav::add_side_data(stream, AV_PKT_DATA_CONTENT_LIGHT_LEVEL, light, size);
}

std::string x265_parameters(const MasteringDisplay& display) {
  const auto point = [](const std::array<double, 2>& xy) {
    return fmt::format("({},{})", chromaticity(xy[0]).num, chromaticity(xy[1]).num);
  };
  return fmt::format("hdr10=1:cll=0:master-display=G{}B{}R{}WP{}L({},{})", point(display.green),
                     point(display.blue), point(display.red), point(display.white),
                     luminance(display.peak_nits).num, luminance(display.black_nits).num);
}

std::vector<BytePatch> light_level_patches(std::span<const std::uint8_t> header, const LightLevel& stated,
                                           const LightLevel& level) {
  const Pattern patterns[] = {
      pattern({'c', 'l', 'l', 'i'}, both(stated), both(level)),             // MP4, MOV
      matroska_element(0xbc, stated.most_nits, level.most_nits),            // MaxCLL
      matroska_element(0xbd, stated.most_mean_nits, level.most_mean_nits),  // MaxFALL
  };
  std::vector<BytePatch> patches;
  for (const Pattern& wanted : patterns) {
    const auto found = std::search(header.begin(), header.end(), wanted.found.begin(), wanted.found.end());
    if (found == header.end()) continue;
    patches.push_back({static_cast<std::size_t>(found - header.begin()) + wanted.before, wanted.replacement});
  }
  return patches;
}

}  // namespace hdrcam
