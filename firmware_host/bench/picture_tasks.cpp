#include "firmware_host/bench/kernel_task_groups.h"

#include <array>
#include <memory>
#include <string>

#include "online/pictures/local_statistics.h"
#include "online/pictures/picture_kernels.h"
#include "online/state/exposure_blur_kernels.h"
#include "render/shrinkage_kernels.h"

namespace hdrcam {
namespace {

// A picture, two flows over it, and room for what is made of it.
struct PictureRoom {
  int rows, cols;
  RandomPlanes in, zoom, chaos, out;

  double pixels() const { return static_cast<double>(rows) * cols; }
};
using SharedRoom = std::shared_ptr<PictureRoom>;

SharedRoom picture_room(int rows, int cols) {
  const auto room =
      std::make_shared<PictureRoom>(PictureRoom{.rows = rows,
                                                .cols = cols,
                                                .in = RandomPlanes(3, rows, cols, 0.01f, 2, 1),
                                                .zoom = RandomPlanes(2, rows, cols, -0.02f, 0.02f, 2),
                                                .chaos = RandomPlanes(2, rows, cols, -6, 6, 2),
                                                .out = RandomPlanes(3, rows, cols, 0, 0, 3)});
  for (int y = 0; y < rows; ++y)  // by one in a hundred, and what a measured flow is unsure of
    for (int x = 0; x < cols; ++x) {
      room->zoom.row(0, y)[x] += 0.01f * static_cast<float>(2 * x - cols) / 2;
      room->zoom.row(1, y)[x] += 0.01f * static_cast<float>(2 * y - rows) / 2;
    }
  return room;
}

// Along a zoom, where neighbours stay together, and along a flow that takes them apart.
template <class Kernel>
void add_warps(KernelTasks& tasks, const SharedRoom& room, const std::string& name, Kernel kernel,
               float limit, PixelWork each) {
  const auto along = [&](RandomPlanes& flow) {
    return [room, &flow, kernel, limit] {
      kernel({.in = room->in.plane(0),
              .out = room->out.plane(0),
              .dx = flow.plane(0),
              .dy = flow.plane(1),
              .channels = 3,
              .rows = room->rows,
              .cols = room->cols,
              .y0 = 0,
              .y1 = room->rows,
              .limit = limit});
    };
  };
  add_picture_kernel(tasks, name, room->pixels(), {.flops = each.flops, .bytes = each.bytes},
                     along(room->zoom));
  add_picture_kernel(tasks, name + ", neighbours apart", room->pixels(), each, along(room->chaos));
}

void add_blur(KernelTasks& tasks, const SharedRoom& room) {
  const auto motion = std::make_shared<RandomPlanes>(2, room->rows, room->cols, 5.98f, 6.02f, 4);
  // 5 instants, of 12 and 7 a channel; neighbours stay together
  constexpr PixelWork kBlur{.flops = 5 * (12 + 3 * 7), .bytes = 32};
  add_picture_kernel(tasks, "exposure's blur, rgb", room->pixels(), kBlur, [room, motion] {
    exposure_blur_kernels().blur({.radiance = room->in.plane(0),
                                  .dx = motion->plane(0),
                                  .dy = motion->plane(1),
                                  .fraction = 0.45f,
                                  .difference = room->out.plane(0),
                                  .channels = 3,
                                  .rows = room->rows,
                                  .cols = room->cols,
                                  .y0 = 0,
                                  .y1 = room->rows});
  });
}

// A picture with its variance, and room for each step of the shrinkage.
struct ShrinkageRoom {
  int rows, cols;
  RandomPlanes in, opponent, sum, weight, out;
};
using SharedShrinkage = std::shared_ptr<ShrinkageRoom>;

constexpr float kOffset = 0.01f;  // of the radiance, before its logarithm

void add_to_opponent(KernelTasks& tasks, const SharedShrinkage& room) {
  add_rows(tasks, "shrinkage: to opponent colours", room->rows, room->cols, {.flops = 90, .planes = 18},
           [room](int y) {
             RandomPlanes &in = room->in, &opponent = room->opponent, &sum = room->sum;
             shrinkage_kernels().to_opponent(
                 {.radiance = {in.row(0, y), in.row(1, y), in.row(2, y)},
                  .variance = {in.row(3, y), in.row(4, y), in.row(5, y)},
                  .offset = kOffset,
                  .opponent = {opponent.row(0, y), opponent.row(1, y), opponent.row(2, y)},
                  .noise = {opponent.row(3, y), opponent.row(4, y), opponent.row(5, y)},
                  .sum = {sum.row(0, y), sum.row(1, y), sum.row(2, y)},
                  .weight = {sum.row(3, y), sum.row(4, y), sum.row(5, y)}},
                 room->cols);
           });
}

void add_tiles(KernelTasks& tasks, const SharedShrinkage& room) {
  std::array<float, kShrinkageTile * kShrinkageTile> thresholds;
  thresholds.fill(1);
  KernelTask task;
  task.name = "shrinkage: tiles of 8x8", task.item = "px";
  const int lines = (room->rows - kShrinkageTile) / kShrinkageStep;
  task.items = static_cast<double>(lines) * kShrinkageStep * room->cols;
  task.run = [room, lines, thresholds] {
    for (int line = 0; line < lines; ++line) {
      const int y = line * kShrinkageStep;
      shrinkage_kernels().shrink({.opponent = room->opponent.row(0, y),
                                  .noise = room->in.row(3, y),
                                  .thresholds = thresholds.data(),
                                  .first = 0,
                                  .cols = room->cols,
                                  .sum = room->sum.row(0, y),
                                  .weight = room->sum.row(3, y)});
    }
  };
  tasks.push_back(std::move(task));
}

void add_to_radiance(KernelTasks& tasks, const SharedShrinkage& room) {
  add_rows(
      tasks, "shrinkage: to radiance", room->rows, room->cols, {.flops = 80, .planes = 9}, [room](int y) {
        RandomPlanes &sum = room->in, &weight = room->weight, &out = room->out;
        shrinkage_kernels().to_radiance({.sum = {sum.row(0, y), sum.row(1, y), sum.row(2, y)},
                                         .weight = {weight.row(0, y), weight.row(1, y), weight.row(2, y)},
                                         .offset = kOffset,
                                         .radiance = {out.row(0, y), out.row(1, y), out.row(2, y)}},
                                        room->cols);
      });
}

}  // namespace

void add_pictures(KernelTasks& tasks, int rows, int cols) {
  const SharedRoom room = picture_room(rows, cols);
  const PictureKernels& kernels = picture_kernels();
  // a place 10, its weights 20 where cubic; 6 a channel where bilinear, 47 where cubic and limited
  add_warps(tasks, room, "warp, bilinear, rgb", kernels.warp_linear, 0,
            {.flops = 10 + 3 * 6, .bytes = 32, .look_ups = 3 * 2});
  add_warps(tasks, room, "warp, bicubic, rgb", kernels.warp_cubic, 0.25f,
            {.flops = 10 + 20 + 3 * 47, .bytes = 32, .look_ups = 3 * 4});
  add_rows(tasks, "mean and variance, 3x3", rows, cols, {.flops = 16, .planes = 3},
           [room, &kernels, rows, cols](int y) {
             kernels.window(
                 window_at(room->in.plane(0), rows, cols, y, 1, room->out.row(0, y), room->out.row(1, y)));
           });
  add_blur(tasks, room);
}

void add_shrinkage(KernelTasks& tasks, int rows, int cols) {
  const auto room =
      std::make_shared<ShrinkageRoom>(ShrinkageRoom{.rows = rows,
                                                    .cols = cols,
                                                    .in = RandomPlanes(6, rows, cols, 0.01f, 1, 1),
                                                    .opponent = RandomPlanes(6, rows, cols, 0, 0, 2),
                                                    .sum = RandomPlanes(6, rows, cols, 0, 0, 3),
                                                    .weight = RandomPlanes(3, rows, cols, 1, 2, 5),
                                                    .out = RandomPlanes(3, rows, cols, 0, 0, 4)});
  add_to_opponent(tasks, room);
  add_tiles(tasks, room);
  add_to_radiance(tasks, room);
}

}  // namespace hdrcam
