#include "hal/core/kernel_table.h"
#include "render/shrinkage_kernels.h"

HDRCAM_KERNEL_TABLE(ShrinkageKernels, kShrinkageKernels, shrinkage_kernels)
