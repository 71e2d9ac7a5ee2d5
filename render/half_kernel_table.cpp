#include "hal/core/kernel_table.h"
#include "render/half_kernels.h"

HDRCAM_KERNEL_TABLE(HalfKernels, kHalfKernels, half_kernels)
