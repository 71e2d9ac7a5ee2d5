#include "render/white_balance.h"

#include <fmt/format.h>

#include <algorithm>

namespace hdrcam {
namespace {

constexpr float kClipped = 0.98f;  // of the radiance that saturates the shortest exposure

}  // namespace

Result<std::optional<ChannelGains>> white_balance_gains(WhiteBalance wanted, const CameraFacts& camera) {
  if (wanted == WhiteBalance::None) return std::optional<ChannelGains>();
  if (!camera.white_balance)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' states no white balance of its camera; leave out --white-balance camera",
                             camera.name)};
  return camera.white_balance;
}

void apply_white_balance(const ChannelGains& gains, HdrFrame& frame) {
  std::array<float, 3> factor{};
  std::ranges::transform(gains, factor.begin(), [](double gain) { return static_cast<float>(gain); });
  const float clipped = kClipped * frame.white;
  constexpr auto kBound = static_cast<std::uint8_t>(Provenance::Bound);
  for (std::size_t i = 0; i < frame.radiance.plane_size(); ++i) {
    const bool bound = frame.provenance.plane(0)[i] == kBound;
    std::array<bool, 3> raised{};
    float most = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      float& radiance = frame.radiance.plane(static_cast<int>(c))[i];
      raised[c] = bound && radiance >= clipped;
      radiance *= factor[c];
      most = std::max(most, radiance);
    }
    for (std::size_t c = 0; c < 3; ++c)
      if (raised[c]) frame.radiance.plane(static_cast<int>(c))[i] = most;
  }
  for (SurfacePoint& point : frame.points)
    for (std::size_t c = 0; c < 3; ++c) point.radiance[c] *= factor[c];
  frame.white *= *std::ranges::max_element(factor);
  frame.white_balance = gains;
}

}  // namespace hdrcam
