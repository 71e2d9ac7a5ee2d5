// From scene-linear radiance to the light of a display that shows HDR video: one fixed scale for the whole
// clip, so that what does not change in the scene does not change on the screen, and a shoulder that takes
// what the cycle can see above the display's peak into its range. Luminance in cd/m2 (nits), linear, Rec.
// ITU-R BT.2020 primaries. Radiance 1 (white of the reference exposure) is shown as `white_nits`. What is
// below the shoulder's knee is exact. Immutable values; reentrant.
#pragma once

#include "hal/core/image.h"

namespace hdrcam {

// SMPTE ST 2084: luminance to signal 0..1 and back. nits: 0..10000.
double pq_signal(double nits);
double pq_nits(double signal);

// The spline of Report ITU-R BT.2390 (EETF, black not lifted): luminance up to `source_peak` into `peak`,
// monotone, with slope 1 in PQ at its knee. Nothing changes where the source does not exceed the peak, but
// that what is above it is clipped.
class HighlightShoulder {
 public:
  HighlightShoulder(double source_peak_nits, double peak_nits);

  double knee_nits() const { return knee_nits_; }
  double shown(double nits) const;

 private:
  double source_signal_;
  double peak_;  // signal, over that of the source
  double peak_nits_;
  double knee_;  // as peak_
  double knee_nits_;
};

// Of one picture, as CTA-861.3 counts it: of each pixel the largest of R, G and B.
struct PictureLight {
  double largest_nits = 0, mean_nits = 0;
};

class DisplayLight {
 public:
  // brightest: radiance that the shoulder still tells apart, such as the saturation of the shortest exposure.
  DisplayLight(double white_nits, double peak_nits, double brightest);

  const HighlightShoulder& shoulder() const { return shoulder_; }
  // radiance: [rgb, rows, cols], BT.709 primaries, finite. light: its first rows and columns are filled; it
  // is at least as large.
  PictureLight show(const Image<float>& radiance, Image<float>& light) const;

 private:
  double white_nits_;
  HighlightShoulder shoulder_;
};

}  // namespace hdrcam
