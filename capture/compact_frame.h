// An exposed frame that waits, in as few bytes as hold it exactly: its codes as the camera wrote them, where
// they are no more than those scaled (to_exposed_frame.h), else as they are. Move-only value.
#pragma once

#include "capture/exposed_frame.h"

namespace hdrcam {

class CompactFrame {
 public:
  CompactFrame() = default;
  // bits: of the camera's codes.
  CompactFrame(const ExposedFrame& frame, int bits);

  // The frame as it was; its storage is reused.
  void restore(ExposedFrame& frame) const;
  const FrameFacts& facts() const { return frame_.facts; }
  float exposure() const { return frame_.exposure; }  // ExposedFrame
  std::size_t bytes() const;                          // of its picture

 private:
  float scale_ = 1;
  ExposedFrame frame_;         // without codes where they are below
  Image<std::uint8_t> bytes_;  // [rgb, rows, cols] codes of at most 8 bits
  Image<std::uint16_t> words_;
};

}  // namespace hdrcam
