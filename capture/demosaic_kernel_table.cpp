#include "capture/demosaic_kernels.h"
#include "hal/core/kernel_table.h"

HDRCAM_KERNEL_TABLE(DemosaicKernels, kDemosaicKernels, demosaic_kernels)
