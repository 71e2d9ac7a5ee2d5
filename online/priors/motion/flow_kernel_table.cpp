#include "hal/core/cpu.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {

namespace baseline {
extern const FlowKernels kFlowKernels;
}
#if defined(__x86_64__)
namespace avx2 {
extern const FlowKernels kFlowKernels;
}
namespace avx512 {
extern const FlowKernels kFlowKernels;
}
const FlowKernels& flow_kernels() {
  return pick_kernels(baseline::kFlowKernels, avx2::kFlowKernels, avx512::kFlowKernels);
}
#else
const FlowKernels& flow_kernels() { return baseline::kFlowKernels; }
#endif

}  // namespace hdrcam
