#include "hal/core/sound_facts.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

namespace hdrcam {
namespace {

constexpr double kLeastFocal_px = 1, kMostFocal_px = 1e6;
constexpr double kMostPictures = 10;     // between the principal point and the picture, in widths or heights
constexpr double kMostDistance_m = 1e7;  // from the world's origin
constexpr double kMostDeviation = 0.01;  // of a product of two rows of a rotation from 0 or 1
constexpr double kLeastRate_hz = 1e-3, kMostRate_hz = 1e5;
constexpr double kLeastGain = 1.0 / 64, kMostGain = 64;  // of a white balance
constexpr double kLongest_s = 86'400;                    // of an exposure
constexpr double kLongestReadout_s = 10;
constexpr std::size_t kResponseCodes = 256;
constexpr double kMostRelativeExposure = 1e12;
constexpr Duration kLatest = std::chrono::seconds(static_cast<std::int64_t>(kLatest_s));

std::optional<std::string> objection_to_response(const std::vector<std::vector<double>>& curves) {
  constexpr const char* kChannels[] = {"red", "green", "blue"};
  if (curves.size() != std::size(kChannels))
    return fmt::format("the response has {} curves; one each of red, green and blue is needed",
                       curves.size());
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const std::vector<double>& curve = curves[c];
    if (curve.size() != kResponseCodes)
      return fmt::format("the response of {} has {} exposures; one for each of {} codes is needed",
                         kChannels[c], curve.size(), kResponseCodes);
    for (std::size_t code = 0; code < curve.size(); ++code) {
      if (!is_within(curve[code], 0, kMostRelativeExposure))
        return fmt::format("the response of {} is {:g} at code {}; 0 to {} are possible", kChannels[c],
                           curve[code], code, kMostRelativeExposure);
      if (code > 0 && curve[code] < curve[code - 1])
        return fmt::format(
            "the response of {} falls at code {}, from {:.9g} to {:.9g}; a brighter code never "
            "means less light",
            kChannels[c], code, curve[code - 1], curve[code]);
    }
    if (curve.back() == 0) return fmt::format("the response of {} is 0 at every code", kChannels[c]);
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> objection_to(const Intrinsics& lens, int width_px, int height_px) {
  for (const auto& [name, focal_px] : {std::pair{"fx", lens.fx_px}, std::pair{"fy", lens.fy_px}})
    if (!is_within(focal_px, kLeastFocal_px, kMostFocal_px))
      return fmt::format("'{}' is {}; a focal length is {} to {} pixels", name, focal_px, kLeastFocal_px,
                         kMostFocal_px);
  for (const auto& [name, centre_px, side_px] :
       {std::tuple{"cx", lens.cx_px, width_px}, std::tuple{"cy", lens.cy_px, height_px}})
    if (!is_within(centre_px, -kMostPictures * side_px, kMostPictures * side_px))
      return fmt::format("'{}' is {}; a principal point is in or near the picture, in pixels", name,
                         centre_px);
  return std::nullopt;
}

std::optional<std::string> objection_to(const PoseMatrix& T) {
  for (const double value : T)
    if (!std::isfinite(value)) return fmt::format("the pose holds {}", value);
  for (const std::size_t place : {3U, 7U, 11U})
    if (std::abs(T[place]) > kMostDistance_m)
      return fmt::format("the pose is {:g} m away; metres of at most {} are possible", T[place],
                         kMostDistance_m);
  const auto product = [&](std::size_t a, std::size_t b) {  // of two rows of the rotation
    return T[4 * a] * T[4 * b] + T[4 * a + 1] * T[4 * b + 1] + T[4 * a + 2] * T[4 * b + 2];
  };
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b)
      if (std::abs(product(a, b) - (a == b ? 1 : 0)) > kMostDeviation)
        return fmt::format("the pose is not a rotation: the product of its rows {} and {} is {:g}, not {}", a,
                           b, product(a, b), a == b ? 1 : 0);
  const double determinant = T[0] * (T[5] * T[10] - T[6] * T[9]) - T[1] * (T[4] * T[10] - T[6] * T[8]) +
                             T[2] * (T[4] * T[9] - T[5] * T[8]);
  if (determinant < 0)
    return "the pose mirrors the world: its determinant is -1; camera axes are right-handed";
  return std::nullopt;
}

std::optional<std::string> objection_to(const ChannelGains& gains) {
  for (const double gain : gains)
    if (!is_within(gain, kLeastGain, kMostGain))
      return fmt::format("the white balance has a gain of {:g}; {} to {} are possible", gain, kLeastGain,
                         kMostGain);
  return std::nullopt;
}

std::optional<std::string> objection_to(const CameraFacts& camera) {
  if (!is_within(camera.framerate_hz, kLeastRate_hz, kMostRate_hz))
    return fmt::format("the frame rate is {:g}; {} to {} frames a second are possible", camera.framerate_hz,
                       kLeastRate_hz, kMostRate_hz);
  if (camera.white_balance)
    if (auto objection = objection_to(*camera.white_balance)) return objection;
  if (!camera.response.empty())
    if (auto objection = objection_to_response(camera.response)) return objection;
  if (camera.intrinsics) return objection_to(*camera.intrinsics, camera.width, camera.height);
  return std::nullopt;
}

std::optional<std::string> objection_to(const FrameFacts& facts, const FrameFacts* before) {
  // NaN or 0, which is no known exposure, is judged by the pictures (capture/recorded_labels.h)
  if (facts.exposure_s < 0 || facts.exposure_s > kLongest_s)
    return fmt::format("its exposure is {:g} s; 0 to {} s are possible", facts.exposure_s, kLongest_s);
  for (const double gain : {facts.analogue_gain, facts.digital_gain})
    if (gain < 0 || gain > kMostExposureGain)
      return fmt::format("its gain is {:g}; 0 to {} are possible", gain, kMostExposureGain);
  if (facts.black_level)
    if (const double black = static_cast<double>((*facts.black_level)[1]); !(black >= 0 && black < 255))
      return fmt::format("its black level is {:g} codes of 255; it is 0 to below 255", black);
  if (!is_within(facts.readout_s, 0, kLongestReadout_s))
    return fmt::format("its rows are read out in {:g} s; 0 to {} s are possible", facts.readout_s,
                       kLongestReadout_s);
  if (facts.timestamp.since_boot > kLatest || facts.timestamp.since_boot < -kLatest)
    return fmt::format("its time is {:g} s; a clock of seconds since its start is needed",
                       facts.timestamp.seconds());
  if (facts.T_world_camera)
    if (auto objection = objection_to(*facts.T_world_camera)) return objection;
  if (before == nullptr) return std::nullopt;
  if (facts.sequence <= before->sequence)
    return fmt::format("its number {} does not come after {}, that of the frame before it", facts.sequence,
                       before->sequence);
  if (facts.timestamp <= before->timestamp)
    return fmt::format("its time {:.6f} s does not come after {:.6f} s, that of the frame before it",
                       facts.timestamp.seconds(), before->timestamp.seconds());
  return std::nullopt;
}

}  // namespace hdrcam
