#include "hal/core/cpu.h"
#include "online/pictures/picture_kernels.h"

namespace hdrcam {

namespace baseline {
extern const PictureKernels kPictureKernels;
}
#if defined(__x86_64__)
namespace avx2 {
extern const PictureKernels kPictureKernels;
}
namespace avx512 {
extern const PictureKernels kPictureKernels;
}
const PictureKernels& picture_kernels() {
  return pick_kernels(baseline::kPictureKernels, avx2::kPictureKernels, avx512::kPictureKernels);
}
#else
const PictureKernels& picture_kernels() { return baseline::kPictureKernels; }
#endif

}  // namespace hdrcam
