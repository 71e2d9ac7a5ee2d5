#include "hal/core/kernel_table.h"
#include "online/state/exposure_blur_kernels.h"
#include "online/state/fusion_kernels.h"

HDRCAM_KERNEL_TABLE(ExposureBlurKernels, kExposureBlurKernels, exposure_blur_kernels)
HDRCAM_KERNEL_TABLE(FusionKernels, kFusionKernels, fusion_kernels)
