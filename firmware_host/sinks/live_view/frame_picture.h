// HDR frames as JPEG pictures to look at: tone-mapped at any exposure, in false colours by radiance, or with
// the provenance of each pixel over them. One tone curve for the run (render/tone_curve.h). A picture is
// encoded once, however many people look at it; nobody looks, nothing is encoded. Thread-bound.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "firmware_host/sinks/live_view/newest_frame.h"
#include "firmware_host/sinks/rgb.h"
#include "firmware_host/web/http_server.h"
#include "render/tone_curve.h"

namespace hdrcam {

enum class PictureLook { Tone, FalseColour, Provenance };
std::optional<PictureLook> picture_look(std::string_view word);  // "tone", "false", "provenance"

// The radiances that false colours and the histogram tell apart, log2.
constexpr double kLeastStop = -12, kMostStop = 8;

// Luminance (render/srgb.h) as log2; of black the least that a half float holds.
double stops_of(float luminance);

struct PictureRequest {
  PictureLook look = PictureLook::Tone;
  double exposure_ev = 0;  // of Tone and Provenance: brighter by so many stops, -16..16

  friend bool operator==(const PictureRequest&, const PictureRequest&) = default;
};

class FramePicture {
 public:
  static constexpr int kWidest_px = 960;  // wider frames are averaged down
  static constexpr int kQuality = 85;

  Result<HttpBody> jpeg(const ShownFrame& frame, const PictureRequest& request);

 private:
  struct Encoded {
    PictureRequest request;
    HttpBody bytes;
  };
  static constexpr std::size_t kMostEncoded = 8;  // of one frame

  ToneAdaptation tone_;
  std::optional<std::uint64_t> sequence_;  // of the frame that is encoded
  ToneAnchors anchors_;
  std::vector<Encoded> encoded_;
};

// The false colours from kLeastStop to kMostStop, evenly spaced.
std::vector<Rgb> false_colour_scale(int steps);

}  // namespace hdrcam
