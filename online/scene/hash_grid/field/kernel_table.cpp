#include "hal/core/cpu.h"
#include "online/scene/hash_grid/field/field_kernels.h"

namespace hdrcam {

namespace baseline {
extern const FieldKernels kFieldKernels;
}
#if defined(__x86_64__)
namespace avx2 {
extern const FieldKernels kFieldKernels;
}
namespace avx512 {
extern const FieldKernels kFieldKernels;
}
const FieldKernels& field_kernels() {
  return pick_kernels(baseline::kFieldKernels, avx2::kFieldKernels, avx512::kFieldKernels);
}
#else
const FieldKernels& field_kernels() { return baseline::kFieldKernels; }
#endif

}  // namespace hdrcam
