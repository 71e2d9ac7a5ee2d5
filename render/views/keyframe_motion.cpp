#include "render/views/keyframe_motion.h"

#include <algorithm>
#include <cmath>

#include "render/srgb.h"

namespace hdrcam {

void KeyframeMotion::match(const Keyframe& before, Keyframe& after) {
  const float white = std::max(before.frame.white, after.frame.white);
  show(before.frame, white, codes_before_);
  show(after.frame, white, codes_after_);
  FlowRequest request{.a = &codes_before_,
                      .b = &codes_after_,
                      .a_to_b = &after.from_previous.vectors,
                      .b_to_a = &after.to_previous.vectors};
  if (!after.frame.flow.empty()) request.start_b_to_a.vectors = &after.frame.flow;
  flow_.compute(FlowQuality::Fine, request);
  agree(after.to_previous, after.from_previous);
  agree(after.from_previous, after.to_previous);
}

// The logarithm gives dark and bright surfaces the same contrast.
void KeyframeMotion::show(const HdrFrame& frame, float white, Image<float>& codes) {
  constexpr float kMu = 500;
  codes.reshape(1, frame.radiance.rows(), frame.radiance.cols());
  const float scale = 255 / std::log1p(kMu);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const float light = luminance_at(frame.radiance, i);
    codes.samples()[i] = scale * std::log1p(kMu * std::clamp(light / white, 0.f, 1.f));
  }
}

// Confidence: the way there and back ends where it began, and inside the picture.
void KeyframeMotion::agree(const FlowField& back, FlowField& flow) {
  constexpr float kDoubtful_px = 1;
  const int rows = flow.vectors.rows(), cols = flow.vectors.cols();
  flow.confidence.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        const float dx = flow.vectors.at(0, y, x), dy = flow.vectors.at(1, y, x);
        const int u = static_cast<int>(std::floor(static_cast<float>(x) + dx + 0.5f));
        const int v = static_cast<int>(std::floor(static_cast<float>(y) + dy + 0.5f));
        float& confidence = flow.confidence.at(0, y, x);
        confidence = 0;
        if (u < 0 || v < 0 || u >= cols || v >= rows) continue;
        const float ex = dx + back.vectors.at(0, v, u), ey = dy + back.vectors.at(1, v, u);
        confidence = 1 / (1 + (ex * ex + ey * ey) / (kDoubtful_px * kDoubtful_px));
      }
  });
}

}  // namespace hdrcam
