#include "capture/photometric_response.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "capture/clip_policy.h"

namespace hdrcam {
namespace {

constexpr std::size_t kGreen = 1;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// ln relative exposure of the mean of 201 real responses, at these codes of 255. Made with the DoRF database
// (Grossberg & Nayar, CVPR 2003): each curve inverted, logarithms averaged.
struct Knot {
  float code, log_exposure;
};
constexpr Knot kMeanCamera[] = {
    {1, -6.627f},   {2, -6.002f},   {4, -5.367f},   {6, -4.989f},   {8, -4.714f},   {12, -4.306f},
    {16, -4.011f},  {24, -3.579f},  {32, -3.262f},  {48, -2.799f},  {64, -2.448f},  {80, -2.156f},
    {96, -1.907f},  {112, -1.686f}, {128, -1.486f}, {144, -1.3f},   {160, -1.125f}, {176, -0.954f},
    {192, -0.784f}, {208, -0.614f}, {224, -0.438f}, {240, -0.245f}, {250, -0.1f},   {255, 0.f}};

float mean_camera(float code) {
  const Knot* above = std::upper_bound(std::begin(kMeanCamera) + 1, std::end(kMeanCamera) - 1, code,
                                       [](float c, const Knot& knot) { return c < knot.code; });
  const Knot* below = above - 1;
  const float t = (code - below->code) / (above->code - below->code);
  return below->log_exposure + t * (above->log_exposure - below->log_exposure);
}

}  // namespace

PhotometricResponse::PhotometricResponse(float darkest, double stretch, float white)
    : darkest_(darkest), clipped_(clip_policy::kPhotometryClipped * (white / 255)), stretch_(stretch) {}

PhotometricResponse PhotometricResponse::unknown(const WhiteLevel& white) {
  constexpr float kDarkest = 24;  // codes of 255
  constexpr double kStretch = 2.8;
  const float at_white = white[kGreen];
  PhotometricResponse response(kDarkest, kStretch, at_white);
  for (std::size_t z = 0; z < 256; ++z)
    response.log_[z] = mean_camera(std::min(255.f, static_cast<float>(z) * (255 / at_white)));
  return response;
}

PhotometricResponse PhotometricResponse::linear(const BlackLevel& black_level) {
  constexpr float kAboveBlack = 6;  // codes of 255
  constexpr double kStretch = 1.03;
  const float black = black_level[kGreen];
  PhotometricResponse response(black + kAboveBlack, kStretch);
  response.linear_ = true;
  response.black_ = black;
  return response;
}

// Black is assumed in the middle of its range. At the darkest code that is used it may be wrong by a quarter
// of the light, which moves the logarithm of a ratio of two by less than `stretch`.
PhotometricResponse PhotometricResponse::linear_unknown_black(float most) {
  constexpr float kMargin = 4;                        // codes of 255
  constexpr double kStretch = 1.05, kWidened = 0.75;  // the latter for the widest range of black
  PhotometricResponse response(2 * most + kMargin,
                               kStretch + kWidened * static_cast<double>(most / kMostBlack));
  response.linear_ = true;
  response.black_ = most / 2;
  return response;
}

PhotometricResponse PhotometricResponse::before_any_fit(bool linear,
                                                        const std::optional<BlackLevel>& black_level,
                                                        const WhiteLevel& white) {
  if (!linear) return unknown(white);
  return black_level ? PhotometricResponse::linear(*black_level) : linear_unknown_black();
}

PhotometricResponse PhotometricResponse::known(const Curve& inverse, const BlackLevel& black_level) {
  constexpr float kAboveBlack = 8;  // codes of 255
  constexpr double kStretch = 1.1;
  const float black = black_level[kGreen];
  const float largest = std::log((255 - black) / 255);  // what the largest code is, as of linear()
  constexpr float kLevel = 1 - 6e-4f;                   // a curve rises by 2e-6 a code where it is level
  const auto white = std::ranges::find_if(inverse, [&](float x) { return x >= kLevel * inverse.back(); });
  const auto below_white = static_cast<float>(inverse.end() - 1 - white);
  PhotometricResponse response(black + kAboveBlack, kStretch, 255 - below_white * (255 - black) / 255);
  for (std::size_t z = 0; z < 256; ++z) {
    const float code = std::max(0.f, (static_cast<float>(z) - black) * 255 / (255 - black));
    const auto below = std::min<std::size_t>(254, static_cast<std::size_t>(code));
    const float t = code - static_cast<float>(below);
    const float exposure = inverse[below] + t * (inverse[below + 1] - inverse[below]);
    response.log_[z] = largest + std::log(std::max(1e-6f, exposure));
  }
  return response;
}

float PhotometricResponse::log_exposure(float code) const {
  if (code < darkest_) return -kInfinity;
  if (code >= clipped_) return kInfinity;
  if (linear_) return std::log((code - black_) / 255);
  const auto below = static_cast<std::size_t>(code);
  return log_[below] + (code - static_cast<float>(below)) * (log_[below + 1] - log_[below]);
}

}  // namespace hdrcam
