#include "firmware_host/bench/kernel_task_groups.h"

#include <array>
#include <memory>

#include "online/pictures/local_statistics.h"
#include "online/pictures/picture_kernels.h"
#include "online/state/exposure_blur_kernels.h"
#include "render/shrinkage_kernels.h"

namespace hdrcam {

void add_pictures(KernelTasks& tasks, int rows, int cols) {
  struct Room {
    RandomPlanes in, zoom, chaos, out;
  };
  const auto room = std::make_shared<Room>(
      Room{RandomPlanes(3, rows, cols, 0.01f, 2, 1), RandomPlanes(2, rows, cols, -0.02f, 0.02f, 2),
           RandomPlanes(2, rows, cols, -6, 6, 2), RandomPlanes(3, rows, cols, 0, 0, 3)});
  for (int y = 0; y < rows; ++y)  // by one in a hundred, and what a measured flow is unsure of
    for (int x = 0; x < cols; ++x) {
      room->zoom.row(0, y)[x] += 0.01f * static_cast<float>(2 * x - cols) / 2;
      room->zoom.row(1, y)[x] += 0.01f * static_cast<float>(2 * y - rows) / 2;
    }
  const PictureKernels& kernels = picture_kernels();
  const auto warp = [&](const char* name, auto kernel, float limit, double flops, double look_ups) {
    for (const bool together : {true, false}) {
      RandomPlanes& flow = together ? room->zoom : room->chaos;
      KernelTask task;
      task.name = std::string(name) + (together ? "" : ", neighbours apart"), task.item = "px";
      task.items = static_cast<double>(rows) * cols;
      task.flops = flops, task.look_ups = together ? 0 : look_ups, task.bytes = 32;
      task.footprint = task.items * task.bytes;
      task.run = [room, &flow, kernel, limit, rows, cols] {
        kernel({.in = room->in.plane(0),
                .out = room->out.plane(0),
                .dx = flow.plane(0),
                .dy = flow.plane(1),
                .channels = 3,
                .rows = rows,
                .cols = cols,
                .y0 = 0,
                .y1 = rows,
                .limit = limit});
      };
      tasks.push_back(std::move(task));
    }
  };
  // a place 10, its weights 20 where cubic; 6 a channel where bilinear, 47 where cubic and limited
  warp("warp, bilinear, rgb", kernels.warp_linear, 0, 10 + 3 * 6, 3 * 2);
  warp("warp, bicubic, rgb", kernels.warp_cubic, 0.25f, 10 + 20 + 3 * 47, 3 * 4);
  add_rows(tasks, "mean and variance, 3x3", rows, cols, 16, 3, [room, &kernels, rows, cols](int y) {
    kernels.window(window_at(room->in.plane(0), rows, cols, y, 1, room->out.row(0, y), room->out.row(1, y)));
  });
  // 5 instants, of 12 and 7 a channel; neighbours stay together
  KernelTask blur;
  blur.name = "exposure's blur, rgb", blur.item = "px";
  blur.items = static_cast<double>(rows) * cols;
  blur.flops = 5 * (12 + 3 * 7), blur.bytes = 32;
  blur.footprint = blur.items * blur.bytes;
  const auto motion = std::make_shared<RandomPlanes>(2, rows, cols, 5.98f, 6.02f, 4);
  blur.run = [room, motion, rows, cols] {
    exposure_blur_kernels().blur({.radiance = room->in.plane(0),
                                  .dx = motion->plane(0),
                                  .dy = motion->plane(1),
                                  .fraction = 0.45f,
                                  .difference = room->out.plane(0),
                                  .channels = 3,
                                  .rows = rows,
                                  .cols = cols,
                                  .y0 = 0,
                                  .y1 = rows});
  };
  tasks.push_back(std::move(blur));
}

void add_shrinkage(KernelTasks& tasks, int rows, int cols) {
  struct Room {
    RandomPlanes in, opponent, sum, out;
  };
  const auto room = std::make_shared<Room>(
      Room{RandomPlanes(6, rows, cols, 0.01f, 1, 1), RandomPlanes(6, rows, cols, 0, 0, 2),
           RandomPlanes(6, rows, cols, 0, 0, 3), RandomPlanes(3, rows, cols, 0, 0, 4)});
  const ShrinkageKernels& kernels = shrinkage_kernels();
  add_rows(tasks, "shrinkage: to opponent colours", rows, cols, 90, 18, [room, &kernels, cols](int y) {
    RandomPlanes &in = room->in, &opponent = room->opponent, &sum = room->sum;
    kernels.to_opponent({.radiance = {in.row(0, y), in.row(1, y), in.row(2, y)},
                         .variance = {in.row(3, y), in.row(4, y), in.row(5, y)},
                         .offset = 0.01f,
                         .opponent = {opponent.row(0, y), opponent.row(1, y), opponent.row(2, y)},
                         .noise = {opponent.row(3, y), opponent.row(4, y), opponent.row(5, y)},
                         .sum = {sum.row(0, y), sum.row(1, y), sum.row(2, y)},
                         .weight = {sum.row(3, y), sum.row(4, y), sum.row(5, y)}},
                        cols);
  });
  std::array<float, kShrinkageTile * kShrinkageTile> thresholds;
  thresholds.fill(1);
  KernelTask tiles;
  tiles.name = "shrinkage: tiles of 8x8", tiles.item = "px";
  const int lines = (rows - kShrinkageTile) / kShrinkageStep;
  tiles.items = static_cast<double>(lines) * kShrinkageStep * cols;
  tiles.run = [room, &kernels, lines, cols, thresholds] {
    for (int line = 0; line < lines; ++line) {
      const int y = line * kShrinkageStep;
      kernels.shrink({.opponent = room->opponent.row(0, y),
                      .noise = room->in.row(3, y),
                      .thresholds = thresholds.data(),
                      .first = 0,
                      .cols = cols,
                      .sum = room->sum.row(0, y),
                      .weight = room->sum.row(3, y)});
    }
  };
  tasks.push_back(std::move(tiles));
  const auto weights = std::make_shared<RandomPlanes>(3, rows, cols, 1.f, 2.f, 5);
  add_rows(tasks, "shrinkage: to radiance", rows, cols, 80, 9, [room, weights, &kernels, cols](int y) {
    RandomPlanes &sum = room->in, &weight = *weights, &out = room->out;
    kernels.to_radiance({.sum = {sum.row(0, y), sum.row(1, y), sum.row(2, y)},
                         .weight = {weight.row(0, y), weight.row(1, y), weight.row(2, y)},
                         .offset = 0.01f,
                         .radiance = {out.row(0, y), out.row(1, y), out.row(2, y)}},
                        cols);
  });
}

}  // namespace hdrcam
