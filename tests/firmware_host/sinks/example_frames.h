// HDR frames for the tests of the sinks: a gradient with a bright spot, every kind of provenance, no random
// values.
#pragma once

#include <cmath>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/fault/faulty_storage.h"

namespace hdrcam::test {

enum class With { RadianceOnly, DepthAndFlow };

inline HdrFrame example_frame(std::uint64_t sequence, With with = With::RadianceOnly, int rows = 24,
                              int cols = 32) {
  HdrFrame frame;
  frame.facts.sequence = sequence;
  frame.facts.timestamp = Instant::from_seconds(5 + static_cast<double>(sequence) / 25);
  frame.facts.exposure_s = 0.004;
  frame.facts.analogue_gain = 2;
  frame.exposure = 0.25f;
  frame.reference_exposure = 0.032;
  frame.white = 16;
  frame.radiance = Image<float>(3, rows, cols);
  frame.sigma = Image<float>(1, rows, cols);
  frame.provenance = Image<std::uint8_t>(1, rows, cols);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) {
      for (int c = 0; c < 3; ++c)
        frame.radiance.at(c, y, x) =
            std::exp2(static_cast<float>(x * 16 / cols - 8)) * (1 + 0.1f * static_cast<float>(c));
      frame.sigma.at(0, y, x) = 0.01f * static_cast<float>(1 + y);
      frame.provenance.at(0, y, x) = static_cast<std::uint8_t>(x * 5 / cols);
    }
  if (with == With::DepthAndFlow) {
    frame.depth = Image<float>(1, rows, cols);
    frame.flow = Image<float>(2, rows, cols);
    frame.field_flow = Image<float>(2, rows, cols);
    frame.field_flow.fill(0.25f);
    frame.flow_forward = Image<float>(2, rows, cols);
    frame.flow_forward.fill(1.0f / 3);
    frame.field_flow_forward = Image<float>(2, rows, cols);
    frame.field_flow_forward.fill(-0.25f);
    frame.length_unit = LengthUnit::FirstDepth;
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        frame.depth.at(0, y, x) = 1 + static_cast<float>(y);
        frame.flow.at(0, y, x) = 0.5f;
        frame.flow.at(1, y, x) = -1.5f;
      }
  }
  return frame;
}

// Emits the frame with its input and its record. codes: [rgb, rows, cols] 0..255.
inline Result<void> emit(FrameSink& sink, const HdrFrame& frame, const Image<float>& codes = {}) {
  ExposedFrame input;
  input.facts = frame.facts;
  input.codes.copy_from(codes);
  FrameRecord record;
  record.sequence = frame.facts.sequence;
  return sink.emit({frame, input, record});
}

// A disk that is full once files have grown by so much in all.
inline StorageFaults disk_of(std::uint64_t bytes) {
  StorageFaults faults;
  faults.space_bytes = bytes;
  return faults;
}

}  // namespace hdrcam::test
