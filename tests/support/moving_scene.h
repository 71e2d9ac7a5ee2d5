// A small synthetic scene with known radiance: a textured background and a disc that moves over it, spanning
// about ten stops, seen through a gamma response. Deterministic: noise comes from a counter-based generator.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "capture/to_exposed_frame.h"
#include "hal/core/frame.h"
#include "online/response/response.h"

namespace hdrcam::test {

struct MovingScene {
  int rows = 48, cols = 64;
  double drift_px = 1.5, disc_px = 3;  // per frame, to the right
  std::vector<double> exposures_s = {0.001, 0.004, 0.016};
  double sensitivity = 250;  // exposure that saturates radiance 1: 1 / sensitivity
  float gamma = 2.2f;
  double full_well = 8000, read_noise = 4;  // electrons; 0 full well: no noise
  bool noise_is_grey = false;               // the same in all channels, as compression leaves it
  int black_level = 0;                      // codes
  double framerate_hz = 30;
  double detail = 1;       // of the texture: below 1 it is smoother
  int covered_frames = 0;  // at the start: of a covered lens

  CameraFacts camera() const {
    CameraFacts facts;
    facts.name = "moving scene";
    facts.width = cols, facts.height = rows;
    facts.framerate_hz = framerate_hz;
    facts.intrinsics =
        Intrinsics{static_cast<double>(cols), static_cast<double>(cols), cols / 2.0, rows / 2.0};
    return facts;
  }

  static double noise(std::uint64_t key) {  // roughly normal: the sum of twelve uniform numbers
    double sum = -6;
    for (int i = 0; i < 12; ++i) {
      key += 0x9e3779b97f4a7c15ull;
      std::uint64_t z = key;
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
      sum += static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }
    return sum;
  }

  double radiance(int frame, int channel, double x, double y) const {
    const double u = (x - drift_px * frame) * detail, v = y * detail;
    double log2_l = -3 + 2.2 * std::sin(u * 0.21) * std::cos(v * 0.17) + 1.5 * std::sin(u * 0.05 + v * 0.09) +
                    0.6 * std::sin(u * 0.9 + v * 0.8) + 0.3 * channel;
    const double dx = x - (cols * 0.3 + disc_px * frame), dy = y - rows * 0.5;
    if (dx * dx + dy * dy < rows * rows * 0.03) log2_l = 1.2 + 0.5 * std::sin(dx) + 0.5 * std::cos(dy * 1.3);
    return std::exp2(log2_l);
  }

  RawFrame frame(int index) const {
    const double exposure = exposures_s[static_cast<std::size_t>(index) % exposures_s.size()];
    RawFrame raw;
    raw.facts.sequence = static_cast<std::uint64_t>(index);
    raw.facts.timestamp = Instant::from_seconds(index / framerate_hz);
    raw.facts.exposure_s = exposure;
    raw.codes = Image<std::uint16_t>(3, rows, cols);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x) {
          const double seen = index < covered_frames ? 0 : radiance(index, c, x, y);
          double light = std::min(1.0, seen * exposure * sensitivity);
          if (full_well > 0) {
            const int channel = noise_is_grey ? 0 : c;
            const auto key = static_cast<std::uint64_t>(((index * 3 + channel) * rows + y) * cols + x);
            light +=
                noise(key) * std::sqrt(light / full_well + read_noise * read_noise / (full_well * full_well));
          }
          const double value = std::pow(std::clamp(light, 0.0, 1.0), 1.0 / static_cast<double>(gamma));
          raw.codes.at(c, y, x) =
              static_cast<std::uint16_t>(std::lround(black_level + (255 - black_level) * value));
        }
    return raw;
  }
};

// A frame of the scene as capture/ hands it on, relative to the middle exposure of its cycle.
inline ExposedFrame exposed(const RawFrame& raw, int index) {
  ExposedFrame frame;
  to_exposed_frame(raw, index, 1 / 30., {.reference_exposure = 0.004}, frame).value();
  return frame;
}

}  // namespace hdrcam::test
