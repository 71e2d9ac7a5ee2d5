// The choice among the objects of one *_kernels.cpp (hdrcam_kernels() in CMakeLists.txt): defines
// `const TABLE& PICK()`, which its header declares, from the constant NAME that each object holds in the
// namespace of its instruction set.
#pragma once

#include "hal/core/cpu.h"

#if defined(__x86_64__)
#define HDRCAM_KERNEL_TABLE(TABLE, NAME, PICK) \
  namespace hdrcam::baseline {                 \
  extern const TABLE NAME;                     \
  }                                            \
  namespace hdrcam::avx2 {                     \
  extern const TABLE NAME;                     \
  }                                            \
  namespace hdrcam::avx512 {                   \
  extern const TABLE NAME;                     \
  }                                            \
  const hdrcam::TABLE& hdrcam::PICK() { return pick_kernels(baseline::NAME, avx2::NAME, avx512::NAME); }
#else
#define HDRCAM_KERNEL_TABLE(TABLE, NAME, PICK) \
  namespace hdrcam::baseline {                 \
  extern const TABLE NAME;                     \
  }                                            \
  const hdrcam::TABLE& hdrcam::PICK() { return baseline::NAME; }
#endif
