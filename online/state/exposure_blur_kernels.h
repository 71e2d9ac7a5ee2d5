// The forward model of exposure_blur.h on raw pointers: one table of functions per instruction set, picked at
// start by exposure_blur_kernels(). Reentrant. Declarations only: the kernels' file may include nothing with
// inline code (CMakeLists.txt).
#pragma once

namespace hdrcam {

constexpr int kBlurChannels = 3;

struct BlurBand {
  const float* radiance;  // [channels, rows, cols], at most kBlurChannels
  const float *dx, *dy;   // [rows, cols] pixels per frame interval
  float fraction;         // of the interval that the exposure lasts
  float* difference;      // as radiance
  int channels, rows, cols;
  int y0, y1;  // the rows to be written
};

struct ExposureBlurKernels {
  void (*blur)(const BlurBand&);
  // whether any of n pixels moves so far that blur() changes it
  bool (*blurs)(const float* dx, const float* dy, float fraction, int n);
};

const ExposureBlurKernels& exposure_blur_kernels();

}  // namespace hdrcam
