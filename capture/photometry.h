// Measures the ratio of the exposures of two neighbouring frames from their pictures alone, so that neither
// the driver nor the sensor can influence it. An exposure scales the whole picture by one factor; motion
// changes parts of it by different factors. The factor is therefore measured twice: at the same place (1200
// sites, aligned for a panning camera) and at the same rank (quantiles, insensitive to motion). Their
// disagreement is the uncertainty. The response turns codes into exposures; while it is unknown, the mean of
// 201 real cameras does, whose spread only stretches a ratio: equal stays equal and brighter stays brighter
// for every camera. Thread-bound; no allocation; a 320x240 picture and its ratios to the seven before it take
// 0.13 ms.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "capture/photometric_response.h"
#include "hal/core/frame.h"
#include "hal/core/image.h"

namespace hdrcam {

// A summary of one frame for comparison with later frames.
struct PhotometricSignature {
  static constexpr int kSiteCols = 40, kSiteRows = 30, kSites = kSiteCols * kSiteRows;

  std::array<float, kSites> at_site;  // ln exposure of a box of pixels, +-inf where clipped or too dark
  std::array<float, kSites> by_rank;  // the same, in order
  int rows = 0, cols = 0;             // of the grid of sites: less for pictures below 160x120
  int sites = 0;
  float clipped_share = 0, dark_share = 0;  // of the sites
  float darkest_code = 255;                 // of all sites, 0..255: an upper bound of the black level

  std::size_t index_of(int y, int x) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(cols) + static_cast<std::size_t>(x);
  }
};

struct SiteShift;  // site_alignment.h

struct PhotometricRatio {
  double log_ratio = 0;      // ln E_b / E_a, the best guess
  double low = 0, high = 0;  // the truth lies between, unless the light itself changes

  bool allows(double value) const { return low <= value && value <= high; }
};

class Photometer {
 public:
  explicit Photometer(const PhotometricResponse& response) : response_(response) {}

  const PhotometricResponse& response() const { return response_; }
  // Earlier signatures use the old response: do not compare them with later ones, unless both are of one
  // linear sensor, each with the black level of its picture.
  void set_response(const PhotometricResponse& response) { response_ = response; }

  // codes: [channels(layout), rows, cols] of `bits` bits. Colour pictures are measured in green.
  void observe(const Image<std::uint16_t>& codes, PixelLayout layout, int bits,
               PhotometricSignature& signature) const;

  // E_b / E_a; nullopt where too little is visible in both, or where they show different scenes.
  std::optional<PhotometricRatio> ratio(const PhotometricSignature& a, const PhotometricSignature& b);

 private:
  struct Centre {
    double median = 0, scatter = 0, sigma = 0;  // of the samples, of the median
  };
  std::optional<Centre> ratio_by_site(const PhotometricSignature& a, const PhotometricSignature& b,
                                      SiteShift shift);
  std::optional<Centre> ratio_by_rank(const PhotometricSignature& a, const PhotometricSignature& b);
  Centre centre(int count, double independent);

  PhotometricResponse response_;
  std::array<float, PhotometricSignature::kSites> scratch_;
};

}  // namespace hdrcam
