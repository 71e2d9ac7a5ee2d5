#include "hal/core/kernel_table.h"
#include "online/pictures/picture_kernels.h"

HDRCAM_KERNEL_TABLE(PictureKernels, kPictureKernels, picture_kernels)
