#include "firmware_host/bench/kernel_task_groups.h"

#include <memory>

#include "online/state/exposure_tables.h"
#include "online/state/fusion_kernels.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

void add_state(KernelTasks& tasks, int rows, int cols) {
  struct Room {
    ExposureTables tables;
    RandomPlanes codes, radiance, share, out;
  };
  const auto room = std::make_shared<Room>(
      Room{ExposureTables(Response::gamma(2.2f), {}, 0.5f), RandomPlanes(2, rows, cols, 0, 255, 1),
           RandomPlanes(9, rows, cols, 0.01f, 1, 2), RandomPlanes(4, rows, cols, 0, 1, 3),
           RandomPlanes(4, rows, cols, 0, 0, 4)});
  const FusionKernels& kernels = fusion_kernels();
  const auto noise = [room] {
    return SampleVariances{room->tables.variances(1).data(), room->tables.exposure()};
  };
  add_rows(tasks, "fusion: samples", rows, cols, 34, 5, [room, &kernels, cols](int y) {
    kernels.sample({room->codes.row(0, y), room->codes.row(1, y), room->tables.radiances(1).data(),
                    room->out.row(0, y), room->out.row(1, y), room->out.row(2, y)},
                   cols);
  });
  add_rows(tasks, "fusion: codes of the state", rows, cols, 40, 7, [room, &kernels, cols](int y) {
    RandomPlanes& r = room->radiance;
    const float* codes = room->tables.codes(1).data();
    kernels.record({.radiance = {r.row(0, y), r.row(1, y), r.row(2, y)},
                    .blur = {r.row(3, y), r.row(4, y), r.row(5, y)},
                    .codes = {codes, codes, codes},
                    .exposure = room->tables.exposure(),
                    .gray = room->out.row(0, y)},
                   cols);
  });
  add_rows(tasks, "fusion: stand-ins", rows, cols, 1, 4, [room, &kernels, cols](int y) {
    RandomPlanes& r = room->radiance;
    kernels.stand_in({r.row(0, y), r.row(1, y), r.row(2, y), 0.5f, room->out.row(0, y)}, cols);
  });
  add_rows(tasks, "fusion: comparison", rows, cols, 25, 11, [room, &kernels, noise, cols](int y) {
    RandomPlanes& r = room->radiance;
    kernels.compare(
        {r.row(0, y), r.row(1, y), r.row(2, y), r.row(3, y), r.row(4, y), room->share.row(0, y), r.row(5, y),
         noise(), 1e6f, 1e-3f, 1e-2f, 0.1f, room->out.row(0, y), room->out.row(1, y)},
        cols);
  });
  add_rows(tasks, "fusion: gate", rows, cols, 67, 13, [room, &kernels, cols](int y) {
    RandomPlanes &r = room->radiance, &s = room->share;
    kernels.gate({r.row(0, y),
                  s.row(0, y),
                  s.row(1, y),
                  {r.row(1, y), r.row(2, y), r.row(3, y)},
                  {r.row(4, y), r.row(5, y), r.row(6, y)},
                  {s.row(2, y), s.row(3, y), s.row(1, y)},
                  2,
                  1,
                  0.01f,
                  room->out.row(3, y)},
                 cols);
  });
  add_rows(tasks, "fusion: update", rows, cols, 35, 11, [room, &kernels, noise, cols](int y) {
    RandomPlanes& r = room->radiance;
    kernels.update({.state = r.row(0, y),
                    .variance = r.row(7, y),
                    .sample = r.row(4, y),
                    .weight = room->share.row(0, y),
                    .mean = r.row(2, y),
                    .blur = r.row(5, y),
                    .gate = room->share.row(1, y),
                    .extra = nullptr,
                    .noise = noise(),
                    .unseen_from = 1e6f,
                    .relative2 = 1e-3f,
                    .blur_variance = 0.1f,
                    .unknown_blur_variance = 1,
                    .least = 1e-3f,
                    .ringing = 0,
                    .bounded = true,
                    .starts = false,
                    .new_state = room->out.row(0, y),
                    .new_variance = room->out.row(1, y),
                    .share = room->out.row(2, y)},
                   cols);
  });
  const auto flow = std::make_shared<RandomPlanes>(2, rows, cols, -6, 6, 5);
  add_rows(tasks, "fusion: variance of a warp", rows, cols, 22, 4, [room, flow, &kernels, cols](int y) {
    kernels.warp_variance({flow->row(0, y), flow->row(1, y), 0.4f, room->out.row(3, y)}, cols);
  });
  add_rows(tasks, "fusion: ageing", rows, cols, 18, 8, [room, &kernels, cols](int y) {
    RandomPlanes& r = room->radiance;
    kernels.age(
        {r.row(0, y), r.row(7, y), room->share.row(0, y), r.row(4, y), room->share.row(1, y), r.row(2, y),
         r.row(3, y), 1.05f, 1e-4f, 0.002f, 1e6f, kUnseenVariance, 1e-3f, room->out.row(3, y)},
        cols);
  });
}

}  // namespace hdrcam
