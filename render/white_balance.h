// The white balance of what leaves: radiance is fitted in the camera's own colours, and only the emitted
// frame is multiplied with gains, those that the camera states for the light of the scene, or others.
// Reentrant.
#pragma once

#include <optional>
#include <string_view>
#include <variant>

#include "hal/core/result.h"
#include "render/hdr_frame.h"

namespace hdrcam {

// As it can be wished for: the camera's own colours, the gains that the camera states, or these.
struct CameraColours {};
struct CameraGains {};
using WhiteBalance = std::variant<CameraColours, CameraGains, ChannelGains>;

// "none", "camera", or gains of R, G and B from 1/64 to 64: "2,1,1.5". nullopt: none of these.
std::optional<WhiteBalance> parse_white_balance(std::string_view text);

// The gains to apply, if any. Errors: Unsupported where the camera's are wanted and it states none.
Result<std::optional<ChannelGains>> white_balance_gains(const WhiteBalance& wanted,
                                                        const CameraFacts& camera);

// Multiplies radiance and points, and notes the gains in the frame. A channel that is clipped in all
// exposures is a lower bound, so it is raised to the largest channel of its pixel: what is too bright for the
// sensor stays white, where the gains alone would make it magenta. `white` becomes that of the largest
// channel.
void apply_white_balance(const ChannelGains& gains, HdrFrame& frame);
// Of a picture that has no such bounds, as of the field alone.
void apply_white_balance(const ChannelGains& gains, Image<float>& radiance);

// Those of both, one after the other.
std::optional<ChannelGains> gains_of_both(const std::optional<ChannelGains>& a,
                                          const std::optional<ChannelGains>& b);

// The same by the frame's own neutral gains, which it then has no more, and by those that are wanted.
void balance_colours(const std::optional<ChannelGains>& wanted, HdrFrame& frame);

}  // namespace hdrcam
