#include "firmware_host/bench/kernel_tasks.h"

#include <algorithm>
#include <memory>

#include "hal/core/image.h"
#include "online/pictures/local_statistics.h"
#include "online/pictures/picture_kernels.h"
#include "online/priors/motion/clipped_motion_kernels.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/priors/motion/refinement_kernels.h"
#include "online/scene/hash_grid/field/field_kernels.h"
#include "online/scene/hash_grid/field/hash_grid.h"
#include "online/scene/hash_grid/field/random.h"
#include "online/scene/hash_grid/field/view_geometry.h"
#include "online/scene/hash_grid/field/window_kernels.h"
#include "online/state/exposure_blur_kernels.h"
#include "online/state/exposure_tables.h"
#include "online/state/fusion_kernels.h"
#include "render/shrinkage_kernels.h"

namespace hdrcam {
namespace {

// Planes of one size with numbers in a range.
class Planes {
 public:
  Planes(int count, int rows, int cols, float low, float high, std::uint64_t seed)
      : values_(count, rows, cols) {
    Pcg32 random(seed);
    for (float& v : values_.samples()) v = random.uniform(low, high);
  }
  float* row(int plane, int y) { return values_.row(plane, y); }
  float* plane(int plane) { return values_.plane(plane); }
  void fill(int plane, float value) { std::fill_n(values_.plane(plane), values_.plane_size(), value); }

 private:
  Image<float> values_;
};

using Tasks = std::vector<KernelTask>;

// Adds a kernel that takes a picture row by row; channels: it is called once for each.
template <class Row>
void add_rows(Tasks& tasks, std::string name, int rows, int cols, double flops, int planes, Row&& row) {
  KernelTask task;
  task.name = std::move(name), task.item = "px";
  task.items = static_cast<double>(rows) * cols;
  task.flops = flops, task.bytes = 4.0 * planes;
  task.footprint = task.items * task.bytes;
  task.run = [rows, row = std::forward<Row>(row)] {
    for (int y = 0; y < rows; ++y) row(y);
  };
  tasks.push_back(std::move(task));
}

// ---- pictures and state

void add_pictures(Tasks& tasks, int rows, int cols) {
  struct Room {
    Planes in, zoom, chaos, out;
  };
  const auto room =
      std::make_shared<Room>(Room{Planes(3, rows, cols, 0.01f, 2, 1), Planes(2, rows, cols, -0.02f, 0.02f, 2),
                                  Planes(2, rows, cols, -6, 6, 2), Planes(3, rows, cols, 0, 0, 3)});
  for (int y = 0; y < rows; ++y)  // by one in a hundred, and what a measured flow is unsure of
    for (int x = 0; x < cols; ++x) {
      room->zoom.row(0, y)[x] += 0.01f * static_cast<float>(2 * x - cols) / 2;
      room->zoom.row(1, y)[x] += 0.01f * static_cast<float>(2 * y - rows) / 2;
    }
  const PictureKernels& kernels = picture_kernels();
  const auto warp = [&](const char* name, auto kernel, float limit, double flops, double look_ups) {
    for (const bool together : {true, false}) {
      Planes& flow = together ? room->zoom : room->chaos;
      KernelTask task;
      task.name = std::string(name) + (together ? "" : ", neighbours apart"), task.item = "px";
      task.items = static_cast<double>(rows) * cols;
      task.flops = flops, task.look_ups = together ? 0 : look_ups, task.bytes = 32;
      task.footprint = task.items * task.bytes;
      task.run = [room, &flow, kernel, limit, rows, cols] {
        kernel({room->in.plane(0), room->out.plane(0), flow.plane(0), flow.plane(1), 3, rows, cols, 0, rows,
                limit});
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
  const auto motion = std::make_shared<Planes>(2, rows, cols, 5.98f, 6.02f, 4);
  blur.run = [room, motion, rows, cols] {
    exposure_blur_kernels().blur({room->in.plane(0), motion->plane(0), motion->plane(1), 0.45f,
                                  room->out.plane(0), 3, rows, cols, 0, rows});
  };
  tasks.push_back(std::move(blur));
}

void add_state(Tasks& tasks, int rows, int cols) {
  struct Room {
    ExposureTables tables;
    Planes codes, radiance, share, out;
  };
  const auto room = std::make_shared<Room>(Room{
      ExposureTables(Response::gamma(2.2f), {}, 0.5f), Planes(2, rows, cols, 0, 255, 1),
      Planes(9, rows, cols, 0.01f, 1, 2), Planes(4, rows, cols, 0, 1, 3), Planes(4, rows, cols, 0, 0, 4)});
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
    Planes& r = room->radiance;
    const float* codes = room->tables.codes(1).data();
    kernels.record({.radiance = {r.row(0, y), r.row(1, y), r.row(2, y)},
                    .blur = {r.row(3, y), r.row(4, y), r.row(5, y)},
                    .codes = {codes, codes, codes},
                    .exposure = room->tables.exposure(),
                    .gray = room->out.row(0, y)},
                   cols);
  });
  add_rows(tasks, "fusion: stand-ins", rows, cols, 1, 4, [room, &kernels, cols](int y) {
    Planes& r = room->radiance;
    kernels.stand_in({r.row(0, y), r.row(1, y), r.row(2, y), 0.5f, room->out.row(0, y)}, cols);
  });
  add_rows(tasks, "fusion: comparison", rows, cols, 25, 11, [room, &kernels, noise, cols](int y) {
    Planes& r = room->radiance;
    kernels.compare(
        {r.row(0, y), r.row(1, y), r.row(2, y), r.row(3, y), r.row(4, y), room->share.row(0, y), r.row(5, y),
         noise(), 1e6f, 1e-3f, 1e-2f, 0.1f, room->out.row(0, y), room->out.row(1, y)},
        cols);
  });
  add_rows(tasks, "fusion: gate", rows, cols, 67, 13, [room, &kernels, cols](int y) {
    Planes &r = room->radiance, &s = room->share;
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
    Planes& r = room->radiance;
    kernels.update({r.row(0, y), r.row(7, y), r.row(4, y), room->share.row(0, y), r.row(2, y), r.row(5, y),
                    room->share.row(1, y), nullptr, noise(), 1e6f, 1e-3f, 0.1f, 1, 1e-3f, false,
                    room->out.row(0, y), room->out.row(1, y), room->out.row(2, y)},
                   cols);
  });
  const auto flow = std::make_shared<Planes>(2, rows, cols, -6, 6, 5);
  add_rows(tasks, "fusion: variance of a warp", rows, cols, 22, 4, [room, flow, &kernels, cols](int y) {
    kernels.warp_variance({flow->row(0, y), flow->row(1, y), 0.4f, room->out.row(3, y)}, cols);
  });
  add_rows(tasks, "fusion: ageing", rows, cols, 18, 8, [room, &kernels, cols](int y) {
    Planes& r = room->radiance;
    kernels.age({r.row(0, y), r.row(7, y), room->share.row(0, y), r.row(4, y), room->share.row(1, y),
                 r.row(2, y), r.row(3, y), 1.05f, 1e-4f, 0.002f, 1e6f, 1e9f, 1e-3f, room->out.row(3, y)},
                cols);
  });
}

// ---- the emission

void add_shrinkage(Tasks& tasks, int rows, int cols) {
  struct Room {
    Planes in, opponent, sum, out;
  };
  const auto room =
      std::make_shared<Room>(Room{Planes(6, rows, cols, 0.01f, 1, 1), Planes(6, rows, cols, 0, 0, 2),
                                  Planes(6, rows, cols, 0, 0, 3), Planes(3, rows, cols, 0, 0, 4)});
  const ShrinkageKernels& kernels = shrinkage_kernels();
  add_rows(tasks, "shrinkage: to opponent colours", rows, cols, 90, 18, [room, &kernels, cols](int y) {
    const auto rows_of = [y](Planes& planes, int first) {
      return std::array<float*, 3>{planes.row(first, y), planes.row(first + 1, y), planes.row(first + 2, y)};
    };
    const auto radiance = rows_of(room->in, 0), variance = rows_of(room->in, 3);
    const std::array<const float*, 3> r{radiance[0], radiance[1], radiance[2]};
    const std::array<const float*, 3> v{variance[0], variance[1], variance[2]};
    kernels.to_opponent(r.data(), v.data(), 0.01f, cols, rows_of(room->opponent, 0).data(),
                        rows_of(room->opponent, 3).data(), rows_of(room->sum, 0).data(),
                        rows_of(room->sum, 3).data());
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
      kernels.shrink(room->opponent.row(0, y), room->in.row(3, y), thresholds.data(), 0, cols,
                     room->sum.row(0, y), room->sum.row(3, y));
    }
  };
  tasks.push_back(std::move(tiles));
  const auto weights = std::make_shared<Planes>(3, rows, cols, 1.f, 2.f, 5);
  add_rows(tasks, "shrinkage: to radiance", rows, cols, 80, 9, [room, weights, &kernels, cols](int y) {
    const float* const sum[3] = {room->in.row(0, y), room->in.row(1, y), room->in.row(2, y)};
    const float* const weight[3] = {weights->row(0, y), weights->row(1, y), weights->row(2, y)};
    float* const out[3] = {room->out.row(0, y), room->out.row(1, y), room->out.row(2, y)};
    kernels.to_radiance(sum, weight, 0.01f, cols, out);
  });
}

// ---- motion

void add_motion(Tasks& tasks, int rows, int cols) {
  // two pictures of one texture, the second two pixels to the right
  struct Room {
    Image<float> planes[2], patches, flow, weight, pieces;
    FlowPicture pictures[2];
  };
  const auto room = std::make_shared<Room>();
  const FlowKernels& kernels = flow_kernels();
  Planes texture(1, rows / 4 + 2, cols / 4 + 4, 20, 230, 1);
  for (int i = 0; i < 2; ++i) {
    Image<float>& planes = room->planes[i] = Image<float>(3, rows + 2 * kFlowBorder, cols + 2 * kFlowBorder);
    const auto origin = [&](int plane) { return planes.row(plane, kFlowBorder) + kFlowBorder; };
    const std::ptrdiff_t pitch = planes.cols();
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        const float u = static_cast<float>(x + 2 * i) / 4, v = static_cast<float>(y) / 4;
        const int ui = static_cast<int>(u), vi = static_cast<int>(v);
        const float fu = u - static_cast<float>(ui), fv = v - static_cast<float>(vi);
        const float *above = texture.row(0, vi) + ui, *below = texture.row(0, vi + 1) + ui;
        origin(0)[y * pitch + x] =
            (1 - fv) * (above[0] + fu * (above[1] - above[0])) + fv * (below[0] + fu * (below[1] - below[0]));
      }
    kernels.extend(origin(0), pitch, rows, cols);
    kernels.derive(origin(0), pitch, rows, cols, origin(1), origin(2));
    room->pictures[i] = {origin(0), origin(1), origin(2), pitch, rows, cols};
  }
  constexpr int kStride = 4, kSteps = 4;
  const PatchGrid grid{1 + (rows - kPatchSize + kStride - 1) / kStride,
                       1 + (cols - kPatchSize + kStride - 1) / kStride, kStride};
  room->patches = Image<float>(2, grid.rows, grid.cols);
  room->flow = Image<float>(2, rows, cols);
  room->weight = Image<float>(1, rows, cols);
  const auto piece = static_cast<int>(refinement_kernels().piece_floats(rows, cols));
  room->pieces = Image<float>(kRefinementPieces, 1, piece);
  const auto search = [room, grid] {
    return PatchSearch{
        room->pictures[0], room->pictures[1], grid,  {room->patches.plane(0), room->patches.plane(1)},
        nullptr,           nullptr,           kSteps};
  };
  const auto task = [&](const char* name, const char* item, double items, auto run) {
    KernelTask added;
    added.name = name, added.item = item, added.items = items, added.run = run;
    tasks.push_back(std::move(added));
  };
  const double pixels = static_cast<double>(rows) * cols;
  task("flow: inverse search, 2 x 4 steps", "patches", static_cast<double>(grid.rows) * grid.cols,
       [room, search, &kernels, grid] {
         room->patches.fill(0);
         kernels.search(search(), 0, grid.rows);
       });
  task("flow: patches to pixels", "px", pixels, [room, search, &kernels, rows] {
    kernels.spread(search(), 0, rows, {room->flow.plane(0), room->flow.plane(1)}, room->weight.plane(0));
  });
  // a place 10, two vectors read 12, their sum and its length 6, an exponential 20, bounds 4
  const auto vectors = std::make_shared<Planes>(4, rows, cols, -1, 1, 3);
  add_rows(tasks, "flow: rating", rows, cols, 52, 5, [room, vectors, &kernels, rows, cols](int y) {
    kernels.rate({.there = vectors->plane(0),
                  .back = vectors->plane(2),
                  .rows = rows,
                  .cols = cols,
                  .y0 = y,
                  .y1 = y + 1,
                  .codes = nullptr,
                  .darkest = 0,
                  .brightest = 255,
                  .assumed = 0.5f,
                  .confidence = room->weight.plane(0)});
  });
  // three rounds of two places, seven components read, a mean and a bend; a last place, two shares; all of it
  // clipped
  const auto clipped = std::make_shared<Planes>(2, rows, cols, 0.7f, 0.75f, 6);
  clipped->fill(1, 0);
  add_rows(tasks, "motion over a clipped frame", rows, cols, 3 * 100 + 50, 15,
           [room, vectors, clipped, rows, cols](int y) {
             clipped_motion_kernels().bridge({{rows, cols, y},
                                              clipped->row(0, y),
                                              clipped->plane(1),
                                              {.after_to_state = vectors->plane(0),
                                               .state_to_after = vectors->plane(2),
                                               .last = vectors->plane(0),
                                               .measured = clipped->plane(0),
                                               .share = 0.5f,
                                               .before = 0.5f},
                                              room->flow.row(0, y),
                                              room->flow.row(1, y),
                                              room->weight.row(0, y)});
           });
  // a place, three components read, a change, three shares
  add_rows(tasks, "motion of the next step", rows, cols, 60, 9, [room, vectors, clipped, rows, cols](int y) {
    clipped_motion_kernels().predict({.at = {rows, cols, y},
                                      .u = vectors->row(0, y),
                                      .v = vectors->row(1, y),
                                      .measured = clipped->row(0, y),
                                      .last = vectors->plane(2),
                                      .measured_before = clipped->plane(0),
                                      .ratio = 1,
                                      .next_u = room->flow.row(0, y),
                                      .next_v = room->flow.row(1, y)});
  });
  task("flow: refinement, 5 x 5 sweeps", "px", pixels, [room] {
    FlowRefinement refinement{room->pictures[0],
                              room->pictures[1],
                              {room->flow.plane(0), room->flow.plane(1)},
                              {},
                              0.5f,
                              10,
                              0.1f,
                              5,
                              5};
    for (int i = 0; i < kRefinementPieces; ++i) refinement.room[i] = room->pieces.plane(i);
    refinement_kernels().refine(refinement);
  });
  // 40 to begin with; 46 and 13 lines to weigh a round, 28 a sweep, of which one round takes 10 lines through
  // the cache
  KernelTask& refinement = tasks.back();
  refinement.flops = 40 + 5 * 46 + 25 * 28, refinement.bytes = 4 * (14 + 5 * (13 + 10));
  refinement.footprint = pixels * 4 * (11 + 2);
}

// ---- the field

void add_window(Tasks& tasks, int rows, int cols) {
  struct Room {
    Planes in, flow, out;
  };
  const auto room = std::make_shared<Room>(Room{
      Planes(3, rows, cols, 0.01f, 1, 1), Planes(2, rows, cols, -6, 6, 2), Planes(3, rows, cols, 0, 0, 3)});
  add_rows(tasks, "window: base", rows, cols, 30, 4, [room, cols](int y) {
    window_kernels().base(
        {room->in.row(0, y), room->in.row(1, y), 1e6f, 0.1f, room->out.row(0, y), room->out.row(1, y)}, cols);
  });
  // half as many blocks as a row has pixels: two rows each
  add_rows(tasks, "window: state of blocks", rows / 2, cols / 2, 16, 10, [room, cols](int y) {
    const auto blocks = [&](int channel, int x, int n) {
      return BlockRow{
          {room->in.row(channel, 2 * y) + 2 * x, room->in.row(channel, 2 * y + 1) + 2 * x}, 2, 2 * n};
    };
    for (int x = 0; x < cols / 2; x += kMostBlocks) {
      const int n = std::min(kMostBlocks, cols / 2 - x);
      window_kernels().block_state(
          {blocks(0, x, n), blocks(1, x, n), 1e6f, room->out.row(0, y) + x, room->out.row(1, y) + x}, n);
    }
  });
  add_rows(tasks, "window: flow lifted to surfaces", rows, cols, 50, 7, [room, rows, cols](int y) {
    const float camera[3][4] = {{1, 0, 0, 0.01f}, {0, 1, 0, 0}, {0, 0, 1, 0.01f}};
    const auto half_width = static_cast<float>(cols) / 2, half_height = static_cast<float>(rows) / 2;
    window_kernels().lift({room->flow.row(0, y),
                           room->flow.row(1, y),
                           room->in.row(0, y),
                           room->in.row(1, y),
                           0.5f,
                           static_cast<float>(y) + 0.5f,
                           camera,
                           camera,
                           {2 * half_width, 2 * half_width},
                           {half_width, half_height},
                           ViewGeometry<float>::kNearest,
                           512,
                           room->out.row(0, y),
                           room->out.row(1, y),
                           room->out.row(2, y)},
                          cols);
  });
}

void add_field(Tasks& tasks) {
  constexpr int kSamples = 256, kWidth = 32;
  struct Room {
    Pcg32 random{1};
    HashGrid<float> grid{HashGridShape(), 1e-2f, random};
    Planes position{3, 1, kSamples, 0, 1, 2}, x{kWidth, 1, kSamples, -1, 1, 3},
        y{kWidth, 1, kSamples, -1, 1, 4};
    Planes weights{1, kWidth, kWidth, -1, 1, 5}, d_weights{1, kWidth, kWidth, 0, 0, 6};
    Planes bias{2, 1, kWidth, -1, 1, 7};
    Image<std::int32_t> slot{1, 1, kSamples};
    Planes moments{2, 1, 1 << 16, 0, 1e-3f, 8}, gradient{2, 1, 1 << 16, -1e-3f, 1e-3f, 9};
  };
  const auto room = std::make_shared<Room>();
  room->grid.reserve_gradient();
  const FieldKernels& kernels = field_kernels();
  const auto query = [room] {
    Planes& p = room->position;
    return GridQuery{{p.plane(0), p.plane(1), p.plane(2)}, room->slot.plane(0), kSamples};
  };
  const auto add = [&](std::string name, const char* item, double items, double flops, double look_ups,
                       auto run) {
    KernelTask task;
    task.name = std::move(name), task.item = item, task.items = items;
    task.flops = flops, task.look_ups = look_ups, task.run = run;
    tasks.push_back(std::move(task));
  };
  const int finest = room->grid.shape().levels - 1;
  for (const int level : {0, finest}) {
    const std::string kind = level == 0 ? ", dense level" : ", hashed level";
    add("field: encode" + kind, "look-ups", 8.0 * kSamples, 0, 1, [room, &kernels, query, level] {
      kernels.encode(room->grid.level(level), room->grid.table(level).data(), query(), room->x.plane(0),
                     room->x.plane(1));
    });
    add("field: scatter" + kind, "look-ups", 8.0 * kSamples, 0, 1, [room, &kernels, query, level] {
      kernels.scatter(room->grid.level(level), room->grid.d_table(level).data(), query(), room->y.plane(0),
                      room->y.plane(1));
    });
  }
  const double layer = 2.0 * kWidth * kWidth * kSamples;
  add("field: layer 32 to 32", "flop", layer, 1, 0, [room, &kernels] {
    kernels.affine(room->weights.plane(0), room->bias.plane(0), room->x.plane(0), kSamples, kSamples, kWidth,
                   kWidth, true, room->y.plane(0));
  });
  add("field: layer 32 to 32, backward", "flop", layer, 1, 0, [room, &kernels] {
    kernels.affine_transposed(room->weights.plane(0), room->x.plane(0), kSamples, kSamples, kWidth, kWidth,
                              room->x.plane(0), room->y.plane(0));
  });
  add("field: layer 32 to 32, its weights", "flop", layer, 1, 0, [room, &kernels] {
    kernels.outer(room->x.plane(0), room->y.plane(0), kSamples, kSamples, kWidth, kWidth,
                  room->d_weights.plane(0), room->bias.plane(1));
  });
  constexpr int kParameters = 1 << 16;
  KernelTask adam;
  adam.name = "field: Adam", adam.item = "parameters", adam.items = kParameters;
  adam.flops = 13, adam.bytes = 40, adam.footprint = 5 * 4.0 * kParameters;
  adam.run = [room, &kernels] {  // which clears the gradient
    std::copy_n(room->gradient.plane(1), kParameters, room->gradient.plane(0));
    kernels.adam({1e-3f, 1, 0.9f, 0.99f, 1e-8f}, kParameters, room->grid.table(0).data(),
                 room->gradient.plane(0), room->moments.plane(0), room->moments.plane(1));
  };
  tasks.push_back(std::move(adam));
}

}  // namespace

std::vector<KernelTask> kernel_tasks(int rows, int cols) {
  Tasks tasks;
  add_motion(tasks, rows, cols);
  add_state(tasks, rows, cols);
  add_pictures(tasks, rows, cols);
  add_shrinkage(tasks, rows, cols);
  add_window(tasks, rows, cols);
  add_field(tasks);
  return tasks;
}

}  // namespace hdrcam
