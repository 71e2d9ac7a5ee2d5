#include "hal/core/freed_pictures.h"

#include <cstdlib>  // defines __GLIBC__
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace hdrcam {
namespace {

// From which size on a block is the system's own, and how much of what is free is kept in the one heap.
void set_limits([[maybe_unused]] int block_bytes, [[maybe_unused]] int kept_bytes) {
#ifdef __GLIBC__
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_THRESHOLD, block_bytes);
  mallopt(M_TRIM_THRESHOLD, kept_bytes);
#endif
}

}  // namespace

void give_back_freed_pictures() { set_limits(4 << 20, 16 << 20); }

FreedPicturesStay::FreedPicturesStay() { set_limits(32 << 20, 512 << 20); }

}  // namespace hdrcam
