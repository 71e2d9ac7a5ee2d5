#include "firmware_host/bench/kernel_task_groups.h"

#include <algorithm>
#include <cstdint>
#include <memory>

#include "online/scene/hash_grid/field/field_kernels.h"
#include "online/scene/hash_grid/field/hash_grid.h"
#include "online/scene/hash_grid/field/view_geometry.h"
#include "online/scene/hash_grid/field/window_kernels.h"

namespace hdrcam {
namespace {

constexpr int kSamples = 256;         // of one evaluation
constexpr int kWidth = 32;            // of a layer
constexpr int kParameters = 1 << 16;  // of one step of Adam

struct FieldRoom {
  Pcg32 random{1};
  HashGrid<float> grid{HashGridShape(), 1e-2f, random};
  RandomPlanes position{3, 1, kSamples, 0, 1, 2}, x{kWidth, 1, kSamples, -1, 1, 3},
      y{kWidth, 1, kSamples, -1, 1, 4};
  RandomPlanes weights{1, kWidth, kWidth, -1, 1, 5}, d_weights{1, kWidth, kWidth, 0, 0, 6};
  RandomPlanes bias{2, 1, kWidth, -1, 1, 7};
  Image<std::int32_t> slot{1, 1, kSamples};
  RandomPlanes moments{2, 1, kParameters, 0, 1e-3f, 8}, gradient{2, 1, kParameters, -1e-3f, 1e-3f, 9};

  FieldRoom() { grid.reserve_gradient(); }
  GridQuery query() {
    return {.position = {position.plane(0), position.plane(1), position.plane(2)},
            .slot = slot.plane(0),
            .n = kSamples};
  }
};
using SharedRoom = std::shared_ptr<FieldRoom>;

// Each corner of a sample's cell is one look-up.
void add_grid(KernelTasks& tasks, const SharedRoom& room) {
  const FieldKernels& kernels = field_kernels();
  const auto add = [&](std::string name, auto run) {
    KernelTask task;
    task.name = std::move(name), task.item = "look-ups";
    task.items = 8.0 * kSamples, task.look_ups = 1, task.run = run;
    tasks.push_back(std::move(task));
  };
  const int finest = room->grid.shape().levels - 1;
  for (const int level : {0, finest}) {
    const std::string kind = level == 0 ? ", dense level" : ", hashed level";
    add("field: encode" + kind, [room, &kernels, level] {
      kernels.encode(room->grid.level(level), room->grid.table(level).data(), room->query(), room->x.plane(0),
                     room->x.plane(1));
    });
    add("field: scatter" + kind, [room, &kernels, level] {
      kernels.scatter(room->grid.level(level), room->grid.d_table(level).data(), room->query(),
                      room->y.plane(0), room->y.plane(1));
    });
  }
}

void add_layers(KernelTasks& tasks, const SharedRoom& room) {
  static constexpr LayerSize kSize{.in = kWidth, .out = kWidth, .ld = kSamples, .n = kSamples};
  constexpr bool kRelu = true;
  const FieldKernels& kernels = field_kernels();
  const auto add = [&](const char* name, auto run) {
    KernelTask task;
    task.name = name, task.item = "flop";
    task.items = 2.0 * kWidth * kWidth * kSamples, task.flops = 1, task.run = run;
    tasks.push_back(std::move(task));
  };
  add("field: layer 32 to 32", [room, &kernels] {
    kernels.affine(kSize, room->weights.plane(0), room->bias.plane(0), room->x.plane(0), kRelu,
                   room->y.plane(0));
  });
  add("field: layer 32 to 32, backward", [room, &kernels] {
    kernels.affine_transposed(kSize, room->weights.plane(0), room->x.plane(0), room->x.plane(0),
                              room->y.plane(0));
  });
  add("field: layer 32 to 32, its weights", [room, &kernels] {
    kernels.outer(kSize, room->x.plane(0), room->y.plane(0), room->d_weights.plane(0), room->bias.plane(1));
  });
}

void add_adam(KernelTasks& tasks, const SharedRoom& room) {
  KernelTask task;
  task.name = "field: Adam", task.item = "parameters", task.items = kParameters;
  task.flops = 13, task.bytes = 40, task.footprint = 5 * 4.0 * kParameters;
  task.run = [room, &kernels = field_kernels()] {  // which clears the gradient
    std::copy_n(room->gradient.plane(1), kParameters, room->gradient.plane(0));
    kernels.adam({.rate = 1e-3f, .gradient_scale = 1, .beta1 = 0.9f, .beta2 = 0.99f, .epsilon = 1e-8f},
                 kParameters, room->grid.table(0).data(), room->gradient.plane(0), room->moments.plane(0),
                 room->moments.plane(1));
  };
  tasks.push_back(std::move(task));
}

struct WindowRoom {
  int rows, cols;
  RandomPlanes in, flow, out;
};
using SharedWindow = std::shared_ptr<WindowRoom>;

void add_window_base(KernelTasks& tasks, const SharedWindow& room) {
  add_rows(tasks, "window: base", room->rows, room->cols, {.flops = 30, .planes = 4}, [room](int y) {
    window_kernels().base({.radiance = room->in.row(0, y),
                           .variance = room->in.row(1, y),
                           .unseen_from = 1e6f,
                           .trusted_sigma = 0.1f,
                           .log_radiance = room->out.row(0, y),
                           .gate = room->out.row(1, y)},
                          room->cols);
  });
}

// Half as many blocks as a row has pixels: two rows each.
void add_block_state(KernelTasks& tasks, const SharedWindow& room) {
  const int rows = room->rows / 2, cols = room->cols / 2;
  add_rows(tasks, "window: state of blocks", rows, cols, {.flops = 16, .planes = 10}, [room, cols](int y) {
    const auto blocks = [&](int channel, int x, int n) {
      return BlockRow{.row = {room->in.row(channel, 2 * y) + 2 * x, room->in.row(channel, 2 * y + 1) + 2 * x},
                      .step = 2,
                      .cols = 2 * n};
    };
    for (int x = 0; x < cols; x += kMostBlocks) {
      const int n = std::min(kMostBlocks, cols - x);
      window_kernels().block_state({.radiance = blocks(0, x, n),
                                    .variance = blocks(1, x, n),
                                    .unseen_from = 1e6f,
                                    .mean = room->out.row(0, y) + x,
                                    .variance_of_mean = room->out.row(1, y) + x},
                                   n);
    }
  });
}

void add_lift(KernelTasks& tasks, const SharedWindow& room) {
  const int rows = room->rows, cols = room->cols;
  add_rows(tasks, "window: flow lifted to surfaces", rows, cols, {.flops = 50, .planes = 7},
           [room, rows, cols](int y) {
             const float camera[3][4] = {{1, 0, 0, 0.01f}, {0, 1, 0, 0}, {0, 0, 1, 0.01f}};
             const auto half_width = static_cast<float>(cols) / 2, half_height = static_cast<float>(rows) / 2;
             window_kernels().lift({.dx = room->flow.row(0, y),
                                    .dy = room->flow.row(1, y),
                                    .confidence = room->in.row(0, y),
                                    .surface = room->in.row(1, y),
                                    .x = 0.5f,
                                    .y = static_cast<float>(y) + 0.5f,
                                    .here = camera,
                                    .there = camera,
                                    .focal = {2 * half_width, 2 * half_width},
                                    .centre = {half_width, half_height},
                                    .nearest = ViewGeometry<float>::kNearest,
                                    .most = 512,
                                    .u = room->out.row(0, y),
                                    .v = room->out.row(1, y),
                                    .sure = room->out.row(2, y)},
                                   cols);
           });
}

}  // namespace

void add_window(KernelTasks& tasks, int rows, int cols) {
  const auto room = std::make_shared<WindowRoom>(WindowRoom{.rows = rows,
                                                            .cols = cols,
                                                            .in = RandomPlanes(3, rows, cols, 0.01f, 1, 1),
                                                            .flow = RandomPlanes(2, rows, cols, -6, 6, 2),
                                                            .out = RandomPlanes(3, rows, cols, 0, 0, 3)});
  add_window_base(tasks, room);
  add_block_state(tasks, room);
  add_lift(tasks, room);
}

void add_field(KernelTasks& tasks) {
  const auto room = std::make_shared<FieldRoom>();
  add_grid(tasks, room);
  add_layers(tasks, room);
  add_adam(tasks, room);
}

}  // namespace hdrcam
