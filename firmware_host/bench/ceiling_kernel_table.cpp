#include "firmware_host/bench/ceiling_kernels.h"
#include "hal/core/kernel_table.h"

HDRCAM_KERNEL_TABLE(CeilingKernels, kCeilingKernels, ceiling_kernels)
