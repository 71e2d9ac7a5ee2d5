#include "firmware_host/bench/kernel_task_groups.h"

#include <cstddef>
#include <memory>
#include <vector>

#include "online/priors/motion/clipped_motion_kernels.h"
#include "online/priors/motion/flow_effort.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/priors/motion/refinement_kernels.h"

namespace hdrcam {
namespace {

constexpr int kTexel_px = 4;
constexpr int kShift_px = 2;  // from the first picture to the second

// What the tasks work on: two pictures of one texture, vectors of any kind, and room for what is found.
struct MotionRoom {
  int rows, cols;
  Image<float> planes[2];  // [gray dx dy, rows, cols] with the border
  FlowPicture pictures[2];
  RandomPlanes vectors;  // of two flows
  Image<float> flow, weight;

  double pixels() const { return static_cast<double>(rows) * cols; }
};
using SharedRoom = std::shared_ptr<MotionRoom>;

// Random texels, bilinear between them.
float texture_at(RandomPlanes& texels, int x_px, int y_px) {
  const float u = static_cast<float>(x_px) / kTexel_px, v = static_cast<float>(y_px) / kTexel_px;
  const int ui = static_cast<int>(u), vi = static_cast<int>(v);
  const float fu = u - static_cast<float>(ui), fv = v - static_cast<float>(vi);
  const float *above = texels.row(0, vi) + ui, *below = texels.row(0, vi + 1) + ui;
  return (1 - fv) * (above[0] + fu * (above[1] - above[0])) + fv * (below[0] + fu * (below[1] - below[0]));
}

void make_texture_pair(MotionRoom& room) {
  const int rows = room.rows, cols = room.cols;
  RandomPlanes texels(1, rows / kTexel_px + 2, cols / kTexel_px + 4, 20, 230, 1);
  for (int i = 0; i < 2; ++i) {
    Image<float>& planes = room.planes[i] = Image<float>(3, rows + 2 * kFlowBorder, cols + 2 * kFlowBorder);
    const auto origin = [&](int plane) { return planes.row(plane, kFlowBorder) + kFlowBorder; };
    const std::ptrdiff_t pitch = planes.cols();
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) origin(0)[y * pitch + x] = texture_at(texels, x + kShift_px * i, y);
    flow_kernels().extend(origin(0), pitch, rows, cols);
    flow_kernels().derive(origin(0), pitch, rows, cols, origin(1), origin(2));
    room.pictures[i] = {
        .gray = origin(0), .dx = origin(1), .dy = origin(2), .pitch = pitch, .rows = rows, .cols = cols};
  }
}

SharedRoom motion_room(int rows, int cols) {
  const auto room = std::make_shared<MotionRoom>(MotionRoom{.rows = rows,
                                                            .cols = cols,
                                                            .planes = {},
                                                            .pictures = {},
                                                            .vectors = RandomPlanes(4, rows, cols, -1, 1, 3),
                                                            .flow = Image<float>(2, rows, cols),
                                                            .weight = Image<float>(1, rows, cols)});
  make_texture_pair(*room);
  return room;
}

template <class Run>
void add_task(KernelTasks& tasks, const char* name, const char* item, double items, Run&& run) {
  KernelTask task;
  task.name = name, task.item = item, task.items = items, task.run = std::forward<Run>(run);
  tasks.push_back(std::move(task));
}

// The dense flow between the two pictures, and its rating.
void add_flow(KernelTasks& tasks, const SharedRoom& room) {
  constexpr int kStride = 4, kSteps = 4;
  const int rows = room->rows, cols = room->cols;
  const FlowKernels& kernels = flow_kernels();
  const PatchGrid grid = patch_grid(rows, cols, kStride);
  const auto patches = std::make_shared<Image<float>>(2, grid.rows, grid.cols);
  const auto search = [room, patches, grid] {
    return PatchSearch{.from = room->pictures[0],
                       .to = room->pictures[1],
                       .grid = grid,
                       .patches = {patches->plane(0), patches->plane(1)},
                       .steps = kSteps};
  };
  add_task(tasks, "flow: inverse search, 2 x 4 steps", "patches", static_cast<double>(grid.rows) * grid.cols,
           [patches, search, &kernels, grid] {
             patches->fill(0);
             kernels.search(search(), 0, grid.rows);
           });
  add_task(tasks, "flow: patches to pixels", "px", room->pixels(), [room, search, &kernels, rows] {
    kernels.spread(search(), 0, rows, {room->flow.plane(0), room->flow.plane(1)}, room->weight.plane(0));
  });
  // a place 8, the sum of there and back and its length 5, an exponential 21, bounds 4
  add_rows(tasks, "flow: rating", rows, cols, {.flops = 38, .planes = 5},
           [room, &kernels, rows, cols](int y) {
             kernels.rate({.there = room->vectors.plane(0),
                           .back = room->vectors.plane(2),
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
}

// A frame that is clipped everywhere, between two that show the motion.
struct ClippedRoom {
  SharedRoom motion;
  RandomPlanes clipped;  // share around each pixel, of this frame and of the one after: about 0.7, and 0
  Image<float> nowhere;  // what lands on a row of cells: nothing
  std::vector<CheckedPathCell> cells;

  PathAhead path() {
    return {.after_to_state = motion->vectors.plane(0),
            .state_to_after = motion->vectors.plane(2),
            .last = motion->vectors.plane(0),
            .measured = clipped.plane(0),
            .share = 0.5f,
            .before = 0.5f};
  }
};
using SharedClipped = std::shared_ptr<ClippedRoom>;

SharedClipped clipped_room(const SharedRoom& motion) {
  const int cells = motion->cols / kLandingCell + 1;
  auto room = std::make_shared<ClippedRoom>(
      ClippedRoom{.motion = motion,
                  .clipped = RandomPlanes(2, motion->rows, motion->cols, 0.7f, 0.75f, 6),
                  .nowhere = Image<float>(1, 1, cells),
                  .cells = std::vector<CheckedPathCell>(static_cast<std::size_t>(cells))});
  room->clipped.fill(1, 0);
  room->nowhere.fill(kNowhere);
  return room;
}

// Two rounds along the path: places 18, a mean 6, a bend 25.
constexpr int kPathFlops = 2 * (18 + 6 + 25);

void add_bridge(KernelTasks& tasks, const SharedClipped& room) {
  const int rows = room->motion->rows, cols = room->motion->cols;
  // behind the path a place 10, two shares 17, what they take over 10
  add_rows(tasks, "motion over a clipped frame", rows, cols, {.flops = kPathFlops + 37, .planes = 15},
           [room, motion = room->motion, rows, cols](int y) {
             clipped_motion_kernels().bridge({.at = {rows, cols, y},
                                              .clipped = room->clipped.row(0, y),
                                              .clipped_after = room->clipped.plane(1),
                                              .path = room->path(),
                                              .landed_u = room->nowhere.row(0, 0),
                                              .landed_v = room->nowhere.row(0, 0),
                                              .from = motion->vectors.plane(0),
                                              .u = motion->flow.row(0, y),
                                              .v = motion->flow.row(1, y),
                                              .measured = motion->weight.row(0, y)});
           });
}

void add_path_check(KernelTasks& tasks, const SharedClipped& room) {
  const int rows = room->motion->rows, cols = room->motion->cols;
  // behind the path a difference 5, a place 10, a share 8, bounds 4, and seven sums of it
  add_rows(tasks, "motion over a clipped frame: check", rows, cols, {.flops = kPathFlops + 34, .planes = 9},
           [room, motion = room->motion, rows, cols](int y) {
             clipped_motion_kernels().compare({.at = {rows, cols, y},
                                               .clipped = room->clipped.row(0, y),
                                               .clipped_after = room->clipped.plane(1),
                                               .path = room->path(),
                                               .u = motion->flow.row(0, y),
                                               .v = motion->flow.row(1, y),
                                               .cells = room->cells.data()});
           });
}

void add_prediction(KernelTasks& tasks, const SharedClipped& room) {
  const int rows = room->motion->rows, cols = room->motion->cols;
  // a place 8, a change 4 and its length 3, two shares 16 and what they make of it 9
  add_rows(tasks, "motion of the next step", rows, cols, {.flops = 40, .planes = 8},
           [room, motion = room->motion, rows, cols](int y) {
             clipped_motion_kernels().predict({.at = {rows, cols, y},
                                               .u = motion->vectors.row(0, y),
                                               .v = motion->vectors.row(1, y),
                                               .measured = room->clipped.row(0, y),
                                               .last = motion->vectors.plane(2),
                                               .measured_before = room->clipped.plane(0),
                                               .ratio = 1,
                                               .next_u = motion->flow.row(0, y),
                                               .next_v = motion->flow.row(1, y)});
           });
}

// The motion over a frame that is clipped everywhere, and the one that is predicted from it.
void add_clipped_motion(KernelTasks& tasks, const SharedRoom& motion) {
  const auto room = clipped_room(motion);
  add_bridge(tasks, room);
  add_path_check(tasks, room);
  add_prediction(tasks, room);
}

void add_refinement(KernelTasks& tasks, const SharedRoom& room) {
  const auto piece = static_cast<int>(refinement_kernels().piece_floats(room->rows, room->cols));
  const auto pieces = std::make_shared<Image<float>>(kRefinementPieces, 1, piece);
  add_task(tasks, "flow: refinement, 5 x 5 sweeps", "px", room->pixels(), [room, pieces] {
    FlowRefinement refinement{.from = room->pictures[0],
                              .to = room->pictures[1],
                              .flow = {room->flow.plane(0), room->flow.plane(1)},
                              .room = {},
                              .data = 0.5f,
                              .slope2 = 10,
                              .smallest = 0.1f,
                              .rounds = 5,
                              .sweeps = 5};
    for (int i = 0; i < kRefinementPieces; ++i) refinement.room[i] = pieces->plane(i);
    refinement_kernels().refine(refinement);
  });
  // 40 to begin with; 46 and 13 lines to weigh a round, 28 a sweep, of which one round takes 10 lines through
  // the cache
  KernelTask& task = tasks.back();
  task.flops = 40 + 5 * 46 + 25 * 28, task.bytes = 4 * (14 + 5 * (13 + 10));
  task.footprint = room->pixels() * 4 * (11 + 2);
}

}  // namespace

void add_motion(KernelTasks& tasks, int rows, int cols) {
  const SharedRoom room = motion_room(rows, cols);
  add_flow(tasks, room);
  add_clipped_motion(tasks, room);
  add_refinement(tasks, room);
}

}  // namespace hdrcam
