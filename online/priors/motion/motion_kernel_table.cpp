#include "hal/core/kernel_table.h"
#include "online/priors/motion/clipped_motion_kernels.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/priors/motion/refinement_kernels.h"

HDRCAM_KERNEL_TABLE(ClippedMotionKernels, kClippedMotionKernels, clipped_motion_kernels)
HDRCAM_KERNEL_TABLE(FlowKernels, kFlowKernels, flow_kernels)
HDRCAM_KERNEL_TABLE(RefinementKernels, kRefinementKernels, refinement_kernels)
