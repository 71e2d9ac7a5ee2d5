#include "online/pictures/warp.h"

#include "online/pictures/picture_kernels.h"

namespace hdrcam {
namespace {

WarpBand whole(const Image<float>& in, const Image<float>& flow, float limit, Image<float>& out) {
  out.reshape_like(in);
  return {in.plane(0), out.plane(0), flow.plane(0), flow.plane(1), in.channels(), in.rows(), in.cols(),
          0,           in.rows(),    limit};
}

}  // namespace

void warp_cubic(const Image<float>& in, const Image<float>& flow, float limit, Image<float>& out,
                WorkerPool& pool) {
  const WarpBand picture = whole(in, flow, limit, out);
  pool.for_rows(in.rows(), [&](int y0, int y1) {
    WarpBand band = picture;
    band.y0 = y0, band.y1 = y1;
    picture_kernels().warp_cubic(band);
  });
}

void warp_linear(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool) {
  const WarpBand picture = whole(in, flow, 0, out);
  pool.for_rows(in.rows(), [&](int y0, int y1) {
    WarpBand band = picture;
    band.y0 = y0, band.y1 = y1;
    picture_kernels().warp_linear(band);
  });
}

}  // namespace hdrcam
