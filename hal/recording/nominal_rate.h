// The rate that a camera or a user means, as the fraction that files state: intervals are rounded, and 29.97
// stands for 30000 / 1001 (SMPTE ST 12-1). One conversion, so that a recording, its video and its OpenEXR
// files state the same rate. Reentrant.
#pragma once

namespace hdrcam {

struct NominalRate {
  int numerator = 0, denominator = 1;  // Hz

  friend bool operator==(const NominalRate&, const NominalRate&) = default;
};

// What is nearly whole becomes whole, 29.97 and its like n * 1000 / 1001, any other the nearest fraction of
// numbers up to 2^20. Of NaN 0 / 0.
NominalRate nominal_rate(double hz);

}  // namespace hdrcam
