// How much more a motion blurs the longer of two exposures than the shorter one. Blur takes dark and bright
// pixels away: the histogram of a blurred frame is narrower, and would match that of a sharp one at wrong
// codes, the darkest by half a stop and more. The shorter frame, blurred as much, has the histogram that
// belongs to it. No motion is known when the response is learned: the lengths are those at which the shorter
// frame, brought to the codes of the longer one, has no more fine texture than that. They are believed where
// its coarse texture then is the same, too, and where most of the picture has become more like the longer
// one: of a scene in which only objects are blurred, none is. Reentrant.
#pragma once

#include "hal/core/image.h"

namespace hdrcam {

// Of a box that averages light along rows and columns: pixels; 1: no blur.
struct BlurLengths {
  float x = 1, y = 1;

  bool any() const { return x > 1 || y > 1; }
};

// codes: [rgb, rows, cols], 0..255, of two frames of about the same scene. No blur where too little of it is
// seen well in both, or in pictures of less than 16 pixels.
BlurLengths blur_between(const Image<float>& shorter, const Image<float>& longer);

// A channel of such a frame, blurred: [1, rows, cols]. Light is averaged, by the curve of a usual camera.
void blur_channel(const Image<float>& codes, int channel, const BlurLengths& lengths, Image<float>& blurred);

}  // namespace hdrcam
