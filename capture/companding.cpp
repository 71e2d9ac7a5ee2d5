#include "capture/companding.h"

#include <cmath>

namespace hdrcam {

void compand(ExposedFrame& frame) {
  static_assert(kCompanding == 2);
  for (float& code : frame.codes.samples()) code = std::sqrt(code * kMaxCode);
}

}  // namespace hdrcam
