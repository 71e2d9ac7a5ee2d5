// What stated exposures are off: cameras round shutter times to nominal ones. Value type, reentrant.
#pragma once

#include <map>
#include <vector>

namespace hdrcam {

// One exposure of the cycle, and how far the true one lies above it.
struct ExposureCorrection {
  float stated = 0;  // relative to the clip's reference exposure
  float stops = 0;
};

// By the stated exposure, relative to the clip's reference exposure.
class ExposureCorrections {
 public:
  void set(float exposure, double log_ratio) { learned_[key(exposure)] = {exposure, log_ratio}; }
  // What the exposure really was, by what the nearest learned one is off: reported times jitter. As stated
  // where none is the same within kSameExposure.
  float corrected(float exposure) const;
  // All that was learned, shortest exposure first. Of a factor that all share nothing is known: its prior is
  // 1.
  std::vector<ExposureCorrection> learned() const;
  // In 1/64 stop: exposures that differ by less are one.
  static int key(float exposure);

 private:
  struct Learned {
    float stated = 0;
    double log_ratio = 0;  // ln of true over stated
  };
  std::map<int, Learned> learned_;
};

}  // namespace hdrcam
