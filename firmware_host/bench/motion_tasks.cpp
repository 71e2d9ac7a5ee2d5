#include "firmware_host/bench/kernel_task_groups.h"

#include <cstddef>
#include <memory>

#include "online/priors/motion/clipped_motion_kernels.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/priors/motion/refinement_kernels.h"

namespace hdrcam {

void add_motion(KernelTasks& tasks, int rows, int cols) {
  // two pictures of one texture, the second two pixels to the right
  struct Room {
    Image<float> planes[2], patches, flow, weight, pieces;
    FlowPicture pictures[2];
  };
  const auto room = std::make_shared<Room>();
  const FlowKernels& kernels = flow_kernels();
  RandomPlanes texture(1, rows / 4 + 2, cols / 4 + 4, 20, 230, 1);
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
        room->pictures[0], room->pictures[1], grid, {room->patches.plane(0), room->patches.plane(1)}, kSteps};
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
  const auto vectors = std::make_shared<RandomPlanes>(4, rows, cols, -1, 1, 3);
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
  const auto clipped = std::make_shared<RandomPlanes>(2, rows, cols, 0.7f, 0.75f, 6);
  clipped->fill(1, 0);
  const auto nowhere = std::make_shared<Image<float>>(1, 1, cols / kLandingCell + 1);
  nowhere->fill(kNowhere);
  add_rows(tasks, "motion over a clipped frame", rows, cols, 3 * 100 + 50, 15,
           [room, vectors, clipped, nowhere, rows, cols](int y) {
             clipped_motion_kernels().bridge({{rows, cols, y},
                                              clipped->row(0, y),
                                              clipped->plane(1),
                                              {.after_to_state = vectors->plane(0),
                                               .state_to_after = vectors->plane(2),
                                               .last = vectors->plane(0),
                                               .measured = clipped->plane(0),
                                               .share = 0.5f,
                                               .before = 0.5f},
                                              nowhere->row(0, 0),
                                              nowhere->row(0, 0),
                                              vectors->plane(0),
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

}  // namespace hdrcam
