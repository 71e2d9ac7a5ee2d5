#include "capture/compact_frame.h"

#include <algorithm>
#include <cmath>

#include "capture/to_exposed_frame.h"

namespace hdrcam {
namespace {

// Whether every code is a whole one that was scaled.
template <class Code>
bool compacted(const Image<float>& codes, float scale, Image<Code>& compact) {
  compact.reshape(codes.channels(), codes.rows(), codes.cols());
  const std::span<const float> in = codes.samples();
  for (std::size_t i = 0; i < in.size(); ++i) {
    const auto code = static_cast<Code>(std::lround(std::clamp(in[i], 0.f, kMaxCode) / scale));
    compact.samples()[i] = code;
    if (scaled_code(code, scale) != in[i]) return false;
  }
  return true;
}

template <class Code>
void expand(const Image<Code>& compact, float scale, Image<float>& codes) {
  codes.reshape(compact.channels(), compact.rows(), compact.cols());
  for (std::size_t i = 0; i < compact.size(); ++i)
    codes.samples()[i] = scaled_code(compact.samples()[i], scale);
}

}  // namespace

CompactFrame::CompactFrame(const ExposedFrame& frame, int bits)
    : scale_(code_scale(bits)), frame_(frame.without_codes()) {
  const bool small =
      bits <= 8 ? compacted(frame.codes, scale_, bytes_) : compacted(frame.codes, scale_, words_);
  if (small) return;
  bytes_ = {}, words_ = {};
  frame_.codes = frame.codes.clone();
}

void CompactFrame::restore(ExposedFrame& frame) const {
  copy_all_but_codes(frame_, frame);
  if (!bytes_.empty())
    expand(bytes_, scale_, frame.codes);
  else if (!words_.empty())
    expand(words_, scale_, frame.codes);
  else
    frame.codes.copy_from(frame_.codes);
}

std::size_t CompactFrame::bytes() const {
  return frame_.codes.size() * sizeof(float) + bytes_.size() + words_.size() * sizeof(std::uint16_t);
}

}  // namespace hdrcam
