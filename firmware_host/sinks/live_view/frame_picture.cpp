#include "firmware_host/sinks/live_view/frame_picture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware_host/sinks/canvas.h"
#include "firmware_host/sinks/provenance_palette.h"
#include "render/jpeg.h"
#include "render/srgb.h"

namespace hdrcam {
namespace {

constexpr float kLeastHalf = 0x1p-24f;

std::uint8_t false_colour_code(double stops) {
  const double share = (stops - kLeastStop) / (kMostStop - kLeastStop);
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

Image<std::uint8_t> in_false_colours(const Image<float>& radiance) {
  Image<std::uint8_t> codes;
  codes.reshape(1, radiance.rows(), radiance.cols());
  for (std::size_t i = 0; i < codes.size(); ++i)
    codes.samples()[i] = false_colour_code(stops_of(luminance_at(radiance, i)));
  return false_colours(codes);
}

// Half the picture in grey, half the colour of its source.
void lay_over(const Image<std::uint8_t>& provenance, Image<std::uint8_t>& picture) {
  const std::size_t n = picture.plane_size();
  for (std::size_t i = 0; i < n; ++i) {
    const int grey = (picture.plane(0)[i] + 2 * picture.plane(1)[i] + picture.plane(2)[i]) / 4;
    const Rgb colour = kProvenanceLooks[provenance.plane(0)[i]].colour;
    const std::uint8_t parts[] = {colour.r, colour.g, colour.b};
    for (int c = 0; c < 3; ++c) picture.plane(c)[i] = static_cast<std::uint8_t>((grey + parts[c]) / 2);
  }
}

// The curve of the run, shifted: what it shows as grey is darker by so many stops.
ToneCurve shifted(const ToneAnchors& anchors, double exposure_ev) {
  const auto gain = static_cast<float>(std::exp2(-exposure_ev));
  const float mid = std::clamp(anchors.mid * gain, 0x1p-20f, 0x1p20f);
  return ToneCurve({mid, std::clamp(anchors.white * gain, 4 * mid, 0x1p24f)});
}

Image<std::uint8_t> picture_of(const HdrFrame& frame, const PictureRequest& request,
                               const ToneAnchors& anchors) {
  if (request.look == PictureLook::FalseColour) return in_false_colours(frame.radiance);
  Image<std::uint8_t> picture = tone_mapped(frame.radiance, shifted(anchors, request.exposure_ev));
  if (request.look == PictureLook::Provenance) lay_over(frame.provenance, picture);
  return picture;
}

}  // namespace

std::optional<PictureLook> picture_look(std::string_view word) {
  if (word == "tone") return PictureLook::Tone;
  if (word == "false") return PictureLook::FalseColour;
  if (word == "provenance") return PictureLook::Provenance;
  return std::nullopt;
}

double stops_of(float luminance) { return std::log2(static_cast<double>(std::max(kLeastHalf, luminance))); }

Result<HttpBody> FramePicture::jpeg(const ShownFrame& frame, const PictureRequest& request) {
  if (sequence_ != frame.hdr.facts.sequence) {
    sequence_ = frame.hdr.facts.sequence;
    anchors_ = tone_.follow(frame.hdr.radiance).anchors();
    encoded_.clear();
  }
  const auto done = std::ranges::find(encoded_, request, &Encoded::request);
  if (done != encoded_.end()) return done->bytes;
  Image<std::uint8_t> picture = picture_of(frame.hdr, request, anchors_);
  if (picture.cols() > kWidest_px)
    picture = resized(picture, rows_at_width(picture.rows(), picture.cols(), kWidest_px), kWidest_px);
  auto bytes = std::make_shared<const std::vector<std::byte>>(TRY(encode_jpeg(picture, kQuality)));
  if (encoded_.size() == kMostEncoded) encoded_.erase(encoded_.begin());
  encoded_.push_back({request, bytes});
  return HttpBody(std::move(bytes));
}

std::vector<Rgb> false_colour_scale(int steps) {
  Image<std::uint8_t> codes(1, 1, steps);
  for (int i = 0; i < steps; ++i) codes.at(0, 0, i) = static_cast<std::uint8_t>(255 * i / (steps - 1));
  const Image<std::uint8_t> colours = false_colours(codes);
  std::vector<Rgb> scale;
  scale.reserve(static_cast<std::size_t>(steps));
  for (int i = 0; i < steps; ++i)
    scale.push_back({colours.at(0, 0, i), colours.at(1, 0, i), colours.at(2, 0, i)});
  return scale;
}

}  // namespace hdrcam
