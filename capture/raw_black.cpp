#include "capture/raw_black.h"

#include <algorithm>

namespace hdrcam {

RawBlack::RawBlack(const std::optional<BlackLevel>& user, const CameraCapabilities& camera,
                   const std::optional<KnownSensor>& table, bool linear)
    : stated_(user ? user : camera.black_level), by_user_(user.has_value()), linear_(linear) {
  if (!stated_ && table && linear) stated_ = table->black_level;
  if (unreported()) most_ = PhotometricResponse::kMostBlack;
}

PhotometricResponse RawBlack::first_response() const {
  return PhotometricResponse::before_any_fit(linear_, stated_);
}

bool RawBlack::adopt(const std::optional<BlackLevel>& with_frame) {
  if (!most_ || !with_frame) return false;
  stated_ = with_frame;
  most_.reset();
  return true;
}

std::optional<PhotometricResponse> RawBlack::narrow(const PhotometricSignature& picture) {
  constexpr float kNoise = 0.5f, kLeast = 1;  // codes of 255
  if (!most_ || *most_ <= kLeast) return std::nullopt;
  const float bound = std::max(kLeast, picture.darkest_code + kNoise);
  if (bound > *most_ / 2) return std::nullopt;
  most_ = bound;
  return PhotometricResponse::linear_unknown_black(bound);
}

}  // namespace hdrcam
