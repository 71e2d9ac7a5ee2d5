#include "capture/to_exposed_frame.h"

#include <cmath>

#include "capture/demosaic.h"
#include "capture/exposure.h"

namespace hdrcam {

Result<ExposedFrame> to_exposed_frame(const RawFrame& raw, int index, double interval_s,
                                      const ExposedFrameSettings& settings) {
  ExposedFrame frame;
  TRY(to_exposed_frame(raw, index, interval_s, settings, frame));
  return frame;
}

Result<void> to_exposed_frame(const RawFrame& raw, int index, double interval_s,
                              const ExposedFrameSettings& settings, ExposedFrame& frame) {
  TRY(check_exposure(raw.facts));
  frame.facts = raw.facts;
  frame.index = index;
  frame.interval_s = interval_s;
  frame.reference_exposure = settings.reference_exposure;
  frame.exposure = static_cast<float>(raw.facts.exposure() / settings.reference_exposure);
  const bool blurs =
      interval_s > 0 && raw.facts.has_exposure_time() && !outlasts_frame(raw.facts.exposure_s, interval_s);
  frame.blur_fraction = blurs ? static_cast<float>(std::min(1.0, raw.facts.exposure_s / interval_s)) : 0;

  const float scale = code_scale(settings.bits);
  if (is_bayer(settings.layout)) {
    demosaic(raw.codes, settings.layout, kMaxCode / scale, frame.codes, scale);
    return {};
  }
  const int channels = raw.codes.channels();
  frame.codes.reshape(3, raw.codes.rows(), raw.codes.cols());
  for (int c = 0; c < 3; ++c) {
    const std::uint16_t* in = raw.codes.plane(channels == 3 ? c : 0);
    float* out = frame.codes.plane(c);
    for (std::size_t i = 0; i < frame.codes.plane_size(); ++i) out[i] = scaled_code(in[i], scale);
  }
  return {};
}

Result<void> check_exposure(const FrameFacts& facts) {
  const double exposure = facts.exposure();
  if (exposure > 0 && std::isfinite(exposure)) return {};
  return Error{ErrorCode::BadExposure,
               fmt::format("frame {} has exposure {} s x gain {}; it must be positive and finite",
                           facts.sequence, facts.exposure_s, facts.gain())};
}

void remove_black_level(ExposedFrame& frame, const BlackLevel& black_level) {
  for (int c = 0; c < 3; ++c) {
    const float black = black_level[static_cast<std::size_t>(c)];
    if (black <= 0) continue;
    const float scale = kMaxCode / (kMaxCode - black);
    float* codes = frame.codes.plane(c);
    for (std::size_t i = 0; i < frame.codes.plane_size(); ++i)
      codes[i] = std::max(0.f, (codes[i] - black) * scale);
  }
}

}  // namespace hdrcam
