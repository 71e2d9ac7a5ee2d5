#include "render/white_balance.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "hal/core/parse_number.h"
#include "hal/core/sound_facts.h"

namespace hdrcam {
namespace {

constexpr float kClipped = 0.98f;  // of the radiance that saturates the shortest exposure

}  // namespace

std::optional<WhiteBalance> parse_white_balance(std::string_view text) {
  if (text == "none") return CameraColours();
  if (text == "camera") return CameraGains();
  ChannelGains gains{};
  for (std::size_t c = 0; c < gains.size(); ++c) {
    const std::size_t comma = text.find(',');
    const auto gain = parse_number<double>(text.substr(0, comma));
    if (!gain || (comma == text.npos) != (c + 1 == gains.size())) return std::nullopt;
    gains[c] = *gain;
    text.remove_prefix(comma == text.npos ? text.size() : comma + 1);
  }
  if (objection_to(gains)) return std::nullopt;
  return gains;
}

Result<std::optional<ChannelGains>> white_balance_gains(const WhiteBalance& wanted,
                                                        const CameraFacts& camera) {
  if (std::holds_alternative<CameraColours>(wanted)) return std::optional<ChannelGains>();
  if (const auto* gains = std::get_if<ChannelGains>(&wanted)) return std::optional(*gains);
  if (!camera.white_balance)
    return Error{ErrorCode::Unsupported,
                 fmt::format("{} states no white balance of its camera; leave out --white-balance camera, or "
                             "give the gains of red, green and blue, such as 2,1,1.5",
                             called(camera))};
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

void apply_white_balance(const ChannelGains& gains, Image<float>& radiance) {
  for (std::size_t c = 0; c < gains.size(); ++c)
    std::for_each_n(radiance.plane(static_cast<int>(c)), radiance.plane_size(),
                    [gain = static_cast<float>(gains[c])](float& light) { light *= gain; });
}

std::optional<ChannelGains> gains_of_both(const std::optional<ChannelGains>& a,
                                          const std::optional<ChannelGains>& b) {
  if (!a || !b) return a ? a : b;
  ChannelGains gains;
  std::ranges::transform(*a, *b, gains.begin(), std::multiplies());
  return gains;
}

void balance_colours(const std::optional<ChannelGains>& wanted, HdrFrame& frame) {
  const auto gains = gains_of_both(std::exchange(frame.neutral_gains, std::nullopt), wanted);
  if (gains) apply_white_balance(*gains, frame);
}

}  // namespace hdrcam
