// ln of the relative exposure of a code 0..255, and its uncertainty, as far as the response of the camera is
// known: the mean of real cameras, raw codes, or what the fit has estimated. It turns codes into exposures
// where pictures are compared (photometry.h). Value type, reentrant.
#pragma once

#include <array>
#include <optional>

#include "hal/core/black_level.h"
#include "hal/core/white_level.h"

namespace hdrcam {

class PhotometricResponse {
 public:
  using Curve = std::array<float, 256>;

  // The mean of real cameras (Grossberg & Nayar's 201 curves). All their ratios are within a factor of 2.8 of
  // this one's on the logarithmic scale, for exposures 1 to 4 stops apart.
  static PhotometricResponse unknown(const WhiteLevel& white = {});
  // Response of raw codes: so many codes above black are the same light whatever the black level. The ratio
  // is measured in green, so the black level of green is used.
  static PhotometricResponse linear(const BlackLevel& black_level);
  // Raw codes with an unreported black level of 0..`most` codes of 255. Codes are used from where that range
  // matters little.
  static PhotometricResponse linear_unknown_black(float most = kMostBlack);
  // What is assumed until a fit has estimated the response. linear: the codes are raw. black_level: where
  // somebody states it. white: of codes that are not.
  static PhotometricResponse before_any_fit(bool linear, const std::optional<BlackLevel>& black_level,
                                            const WhiteLevel& white = {});
  // Relative exposure 0..1 of each code of 255, with black removed and the range stretched again to 255. On
  // the scale of linear(), by which frames of another black level are compared with it. From where it is 1 on
  // codes are clipped.
  static PhotometricResponse known(const Curve& inverse, const BlackLevel& black_level);

  // ln of relative exposure; -inf for codes too dark to measure, +inf for clipped ones.
  float log_exposure(float code) const;
  float clipped_from() const { return clipped_; }  // codes of 255
  // A measured ln ratio may be wrong by this factor in either direction.
  double stretch() const { return stretch_; }

  static constexpr float kMostBlack = 18;  // codes of 255: the largest of all known sensors

 private:
  // white: of 255.
  PhotometricResponse(float darkest, double stretch, float white = 255);

  Curve log_{};      // at whole codes
  float black_ = 0;  // for the linear case, where the logarithm is taken directly
  bool linear_ = false;
  float darkest_;  // codes below it are not used
  float clipped_;  // nor these and those above
  double stretch_;
};

}  // namespace hdrcam
