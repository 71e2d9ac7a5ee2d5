// The noise of one sample: shot, read and quantisation noise, plus a term in the code domain for compression.
// Variances are of relative exposure x (0..1, 1 = full well). Value type, reentrant.
#pragma once

namespace hdrcam {

// Sensor: what the frames show is the sensor's own noise, so that each pixel errs by itself. Unknown: what
// demosaicing, noise reduction or compression may have left, errors that neighbours share.
enum class NoiseOrigin { Unknown, Sensor };

struct NoiseModel {
  float full_well = 4000;  // electrons at x = 1
  float read_noise = 9;    // electrons rms
  float code_noise = 1;    // codes (of 255) rms: compression; .1 for clean streams, 1 to 2 for others
  float code_step = 1;     // of the quantiser, in codes of 255: 1 for 8 bit, 1/16 for 12 bit

  // variance of x from shot and read noise
  float exposure_variance(float x) const {
    const float read = read_noise / full_well;
    return x / full_well + read * read;
  }
  // variance of a code from quantisation and compression
  float code_variance() const { return code_step * code_step / 12 + code_noise * code_noise; }
};

}  // namespace hdrcam
