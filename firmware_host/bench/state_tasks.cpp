#include "firmware_host/bench/kernel_task_groups.h"

#include <memory>

#include "online/state/exposure_tables.h"
#include "online/state/fusion_kernels.h"
#include "online/state/radiance_state.h"

namespace hdrcam {
namespace {

// Two frames' codes, planes in the ranges of radiances and of shares, and room for what is made of them.
struct StateRoom {
  int rows, cols;
  ExposureTables tables;
  RandomPlanes codes, radiance, share, out;

  SampleVariances noise() const { return {tables.variances(1).data(), tables.exposure()}; }
};
using SharedRoom = std::shared_ptr<StateRoom>;

SharedRoom state_room(int rows, int cols) {
  return std::make_shared<StateRoom>(StateRoom{.rows = rows,
                                               .cols = cols,
                                               .tables = ExposureTables(Response::gamma(2.2f), {}, 0.5f),
                                               .codes = RandomPlanes(2, rows, cols, 0, 255, 1),
                                               .radiance = RandomPlanes(9, rows, cols, 0.01f, 1, 2),
                                               .share = RandomPlanes(4, rows, cols, 0, 1, 3),
                                               .out = RandomPlanes(4, rows, cols, 0, 0, 4)});
}

// What a frame says, what the state would have recorded, and which of the two the noise model is asked for.
void add_samples(KernelTasks& tasks, const SharedRoom& room) {
  const FusionKernels& kernels = fusion_kernels();
  const int rows = room->rows, cols = room->cols;
  add_rows(tasks, "fusion: samples", rows, cols, {.flops = 34, .planes = 5}, [room, &kernels, cols](int y) {
    kernels.sample({.codes = room->codes.row(0, y),
                    .brightest = room->codes.row(1, y),
                    .radiances = room->tables.radiances(1).data(),
                    .radiance = room->out.row(0, y),
                    .weight = room->out.row(1, y),
                    .comparable = room->out.row(2, y)},
                   cols);
  });
  add_rows(tasks, "fusion: codes of the state", rows, cols, {.flops = 40, .planes = 7},
           [room, &kernels, cols](int y) {
             RandomPlanes& r = room->radiance;
             const float* codes = room->tables.codes(1).data();
             kernels.record({.radiance = {r.row(0, y), r.row(1, y), r.row(2, y)},
                             .blur = {r.row(3, y), r.row(4, y), r.row(5, y)},
                             .codes = {codes, codes, codes},
                             .exposure = room->tables.exposure(),
                             .gray = room->out.row(0, y)},
                            cols);
           });
  add_rows(tasks, "fusion: stand-ins", rows, cols, {.flops = 1, .planes = 4}, [room, &kernels, cols](int y) {
    RandomPlanes& r = room->radiance;
    kernels.stand_in({.state = r.row(0, y),
                      .variance = r.row(1, y),
                      .sample = r.row(2, y),
                      .unseen_from = 0.5f,
                      .out = room->out.row(0, y)},
                     cols);
  });
}

// How far state and samples agree.
void add_gate(KernelTasks& tasks, const SharedRoom& room) {
  const FusionKernels& kernels = fusion_kernels();
  const int rows = room->rows, cols = room->cols;
  add_rows(tasks, "fusion: comparison", rows, cols, {.flops = 25, .planes = 11},
           [room, &kernels, cols](int y) {
             RandomPlanes& r = room->radiance;
             kernels.compare({.state = r.row(0, y),
                              .variance = r.row(1, y),
                              .mean = r.row(2, y),
                              .contrast = r.row(3, y),
                              .sample = r.row(4, y),
                              .comparable = room->share.row(0, y),
                              .blur = r.row(5, y),
                              .noise = room->noise(),
                              .unseen_from = 1e6f,
                              .relative2 = 1e-3f,
                              .texture2 = 1e-2f,
                              .blur_tolerance = 0.1f,
                              .chi2 = room->out.row(0, y),
                              .covered = room->out.row(1, y)},
                             cols);
           });
  add_rows(tasks, "fusion: gate", rows, cols, {.flops = 67, .planes = 13}, [room, &kernels, cols](int y) {
    RandomPlanes &r = room->radiance, &s = room->share;
    kernels.gate({.chi2 = r.row(0, y),
                  .covered = s.row(0, y),
                  .trust = s.row(1, y),
                  .state = {r.row(1, y), r.row(2, y), r.row(3, y)},
                  .sample = {r.row(4, y), r.row(5, y), r.row(6, y)},
                  .weight = {s.row(2, y), s.row(3, y), s.row(1, y)},
                  .tolerance = 2,
                  .scale = 1,
                  .floor = 0.01f,
                  .gate = room->out.row(3, y)},
                 cols);
  });
}

// The state takes the samples.
void add_update(KernelTasks& tasks, const SharedRoom& room) {
  const FusionKernels& kernels = fusion_kernels();
  const int rows = room->rows, cols = room->cols;
  add_rows(tasks, "fusion: update", rows, cols, {.flops = 35, .planes = 11}, [room, &kernels, cols](int y) {
    RandomPlanes& r = room->radiance;
    kernels.update({.state = r.row(0, y),
                    .variance = r.row(7, y),
                    .sample = r.row(4, y),
                    .weight = room->share.row(0, y),
                    .mean = r.row(2, y),
                    .blur = r.row(5, y),
                    .gate = room->share.row(1, y),
                    .extra = nullptr,
                    .noise = room->noise(),
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
  add_rows(tasks, "fusion: doubt of textures", rows, cols, {.flops = 10, .planes = 3},
           [room, &kernels, cols](int y) {
             RandomPlanes& r = room->radiance;
             kernels.doubt_textures({.mean = r.row(2, y),
                                     .hidden = {room->tables.hidden(1).data(), room->tables.exposure()},
                                     .share = 0.05f,
                                     .doubt = r.row(8, y)},
                                    cols);
           });
}

// The state is carried to the next frame.
void add_carrying(KernelTasks& tasks, const SharedRoom& room) {
  const FusionKernels& kernels = fusion_kernels();
  const int rows = room->rows, cols = room->cols;
  const auto flow = std::make_shared<RandomPlanes>(2, rows, cols, -6, 6, 5);
  add_rows(tasks, "fusion: variance of a warp", rows, cols, {.flops = 22, .planes = 3},
           [room, flow, &kernels, cols](int y) {
             kernels.warp_variance({.dx = flow->row(0, y),
                                    .dy = flow->row(1, y),
                                    .scale = 0.4f,
                                    .per_contrast = room->out.row(3, y)},
                                   cols);
           });
  add_rows(tasks, "fusion: ageing", rows, cols, {.flops = 18, .planes = 8}, [room, &kernels, cols](int y) {
    RandomPlanes& r = room->radiance;
    kernels.age({.state = r.row(0, y),
                 .variance = r.row(7, y),
                 .gate = room->share.row(0, y),
                 .sample = r.row(4, y),
                 .weight = room->share.row(1, y),
                 .contrast = r.row(2, y),
                 .per_contrast = r.row(3, y),
                 .growth = 1.05f,
                 .relative2 = 1e-4f,
                 .floor = 0.002f,
                 .unseen_from = 1e6f,
                 .lost_variance = kUnseenVariance,
                 .least = 1e-3f,
                 .new_variance = room->out.row(3, y)},
                cols);
  });
}

}  // namespace

void add_state(KernelTasks& tasks, int rows, int cols) {
  const SharedRoom room = state_room(rows, cols);
  add_samples(tasks, room);
  add_gate(tasks, room);
  add_update(tasks, room);
  add_carrying(tasks, room);
}

}  // namespace hdrcam
