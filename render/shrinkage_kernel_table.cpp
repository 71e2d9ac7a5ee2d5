#include "hal/core/cpu.h"
#include "render/shrinkage_kernels.h"

namespace hdrcam {

namespace baseline {
extern const ShrinkageKernels kShrinkageKernels;
}
#if defined(__x86_64__)
namespace avx2 {
extern const ShrinkageKernels kShrinkageKernels;
}
namespace avx512 {
extern const ShrinkageKernels kShrinkageKernels;
}
const ShrinkageKernels& shrinkage_kernels() {
  return pick_kernels(baseline::kShrinkageKernels, avx2::kShrinkageKernels, avx512::kShrinkageKernels);
}
#else
const ShrinkageKernels& shrinkage_kernels() { return baseline::kShrinkageKernels; }
#endif

}  // namespace hdrcam
