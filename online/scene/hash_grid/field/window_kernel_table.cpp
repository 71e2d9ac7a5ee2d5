#include "hal/core/kernel_table.h"
#include "online/scene/hash_grid/field/window_kernels.h"

HDRCAM_KERNEL_TABLE(WindowKernels, kWindowKernels, window_kernels)
