#include "hal/core/kernel_table.h"
#include "online/scene/hash_grid/field/field_kernels.h"

HDRCAM_KERNEL_TABLE(FieldKernels, kFieldKernels, field_kernels)
