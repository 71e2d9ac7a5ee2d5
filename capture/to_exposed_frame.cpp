#include "capture/to_exposed_frame.h"

#include <algorithm>
#include <cmath>

#include "capture/demosaic.h"
#include "capture/exposure.h"

namespace hdrcam {
namespace {

// Where exposures end on the camera's grid, the centre of a long one is nearer than a frame to that of a
// short one before it, by less than half a frame; such an exposure blurs more than the motion since then.
double blur_fraction_of(const FrameFacts& facts, double interval_s, double frame_s) {
  if (!(interval_s > 0) || !facts.has_exposure_time()) return 0;
  if (!outlasts_frame(facts.exposure_s, interval_s)) return std::min(1.0, facts.exposure_s / interval_s);
  const double longest_s = std::min(frame_s, 2 * interval_s);
  if (!(longest_s > 0) || outlasts_frame(facts.exposure_s, longest_s)) return 0;
  return std::min(facts.exposure_s, longest_s) / interval_s;
}

}  // namespace

Result<void> to_exposed_frame(const RawFrame& raw, int index, double interval_s,
                              const ExposedFrameSettings& settings, ExposedFrame& frame) {
  TRY(check_exposure(raw.facts));
  frame.facts = raw.facts;
  frame.index = index;
  frame.interval_s = interval_s;
  frame.reference_exposure = settings.reference_exposure;
  frame.white = settings.white;
  frame.exposure = static_cast<float>(raw.facts.exposure() / settings.reference_exposure);
  frame.blur_fraction = static_cast<float>(blur_fraction_of(raw.facts, interval_s, settings.frame_s));

  const float scale = code_scale(settings.bits);
  if (is_bayer(settings.layout)) {
    demosaic(raw.codes, settings.layout, kMaxCode / scale, frame.codes, scale);
    return {};
  }
  const int channels = raw.codes.channels();
  frame.codes.reshape(3, raw.codes.rows(), raw.codes.cols());
  for (int c = 0; c < 3; ++c) {
    const float stretched = scale * (kMaxCode / settings.white[static_cast<std::size_t>(c)]);
    const std::uint16_t* in = raw.codes.plane(channels == 3 ? c : 0);
    float* out = frame.codes.plane(c);
    for (std::size_t i = 0; i < frame.codes.plane_size(); ++i) out[i] = scaled_code(in[i], stretched);
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
