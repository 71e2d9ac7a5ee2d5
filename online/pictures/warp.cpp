#include "online/pictures/warp.h"

#include "online/pictures/picture_kernels.h"

namespace hdrcam {
namespace {

void warp(const Image<float>& in, const Image<float>& flow, float limit, Image<float>& out, WorkerPool& pool,
          void (*kernel)(const WarpBand&), float* largest = nullptr) {
  out.reshape_like(in);
  pool.for_rows(in.rows(), [&](int y0, int y1) {
    kernel({in.plane(0), out.plane(0), flow.plane(0), flow.plane(1), in.channels(), in.rows(), in.cols(), y0,
            y1, limit, largest});
  });
}

}  // namespace

void warp_cubic(const Image<float>& in, const Image<float>& flow, float limit, Image<float>& out,
                WorkerPool& pool) {
  warp(in, flow, limit, out, pool, picture_kernels().warp_cubic);
}

void warp_cubic_and_largest(const Image<float>& in, const Image<float>& flow, Image<float>& out,
                            Image<float>& largest, WorkerPool& pool) {
  largest.reshape_like(in);
  warp(in, flow, 0, out, pool, picture_kernels().warp_cubic, largest.plane(0));
}

void warp_linear(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool) {
  warp(in, flow, 0, out, pool, picture_kernels().warp_linear);
}

}  // namespace hdrcam
