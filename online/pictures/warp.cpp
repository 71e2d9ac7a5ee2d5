#include "online/pictures/warp.h"

#include "hal/core/scratch_pictures.h"
#include "online/pictures/for_samples.h"
#include "online/pictures/picture_kernels.h"

namespace hdrcam {
namespace {

// asked: of the band, what is not the same for all warps.
void warp(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool,
          void (*kernel)(const WarpBand&), WarpBand asked = {}) {
  out.reshape_like(in);
  asked.in = in.plane(0), asked.out = out.plane(0);
  asked.dx = flow.plane(0), asked.dy = flow.plane(1);
  asked.channels = in.channels(), asked.rows = in.rows(), asked.cols = in.cols();
  pool.for_rows(in.rows(), [&](int y0, int y1) {
    WarpBand band = asked;
    band.y0 = y0, band.y1 = y1;
    kernel(band);
  });
}

}  // namespace

void warp_cubic(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool) {
  warp(in, flow, out, pool, picture_kernels().warp_cubic);
}

void warp_cubic_and_largest(const Image<float>& in, const Image<float>& flow, Image<float>& out,
                            Image<float>& largest, WorkerPool& pool) {
  largest.reshape_like(in);
  warp(in, flow, out, pool, picture_kernels().warp_cubic, {.largest = largest.plane(0)});
}

void warp_radiance(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool) {
  Image<float> logarithm;
  const ScratchLease borrowed(pool.scratch(), in.rows(), in.cols(), {{&logarithm, in.channels()}});
  for_samples(in, pool, [&](std::size_t i0, std::size_t i1) {
    picture_kernels().log_radiance({in.plane(0) + i0, logarithm.plane(0) + i0, i1 - i0});
  });
  warp(logarithm, flow, out, pool, picture_kernels().warp_cubic,
       {.limit = kMostRinging, .radiance = in.plane(0)});
}

void warp_linear(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool) {
  warp(in, flow, out, pool, picture_kernels().warp_linear);
}

}  // namespace hdrcam
