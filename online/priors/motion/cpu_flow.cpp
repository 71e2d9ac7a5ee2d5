#include "online/priors/motion/cpu_flow.h"

#include <algorithm>

#include "capture/clip_policy.h"
#include "online/pictures/between_pixels.h"
#include "online/priors/motion/far_patches.h"
#include "online/priors/motion/refinement_kernels.h"

namespace hdrcam {
namespace {

Offset guess_at(const FlowGuess& guess, int x, int y) {
  const Image<float>& vectors = *guess.vectors;
  const Offset here = guess.scale * offset_at(vectors, x, y);
  if (!guess.carried) return here;
  return guess.scale * BetweenPixels(vectors.rows(), vectors.cols(), x, y, here).vector_of(vectors);
}

FlowPlanes planes_of(Image<float>& vectors) { return {vectors.plane(0), vectors.plane(1)}; }

}  // namespace

void CpuFlow::compute(FlowQuality quality, const FlowRequest& request) {
  const int rows = request.a->rows(), cols = request.a->cols();
  for (Image<float>* flow : {request.a_to_b, request.b_to_a}) flow->reshape(2, rows, cols);
  if (rows < kMinSize || cols < kMinSize) {
    request.a_to_b->fill(0), request.b_to_a->fill(0);
    return;
  }
  const FlowEffort effort = effort_of(quality);
  const FlowScales scales = scales_of(effort, rows, cols);
  const int coarsest = scales.coarsest, finest = scales.finest;
  ask(request);
  for (Pyramid& pyramid : pyramids_)
    for (int scale = std::min(finest, 1); scale <= coarsest; ++scale)
      pool_.scratch().acquire(level_of(pyramid, scale).planes, 3, (rows >> scale) + 2 * kFlowBorder,
                              (cols >> scale) + 2 * kFlowBorder);
  pool_.for_each(2, [&](int i) {
    build(i == 0 ? *request.a : *request.b, finest, coarsest, pyramids_[static_cast<std::size_t>(i)]);
  });
  {
    auto& [there, back] = directions_;
    const ScratchLease room(pool_.scratch(), rows >> finest, cols >> finest,
                            {{&there.flow, 2}, {&back.flow, 2}, {&there.weight, 1}, {&back.weight, 1}});
    // each about as large as three planes, which most pictures of others are, who use them too
    const auto piece = static_cast<int>(refinement_kernels().piece_floats(rows >> finest, cols >> finest));
    for (Direction& direction : directions_)
      for (Image<float>& picture : direction.room) pool_.scratch().acquire(picture, 1, 1, piece);
    for (int scale = coarsest; scale >= finest; --scale) match(scale, scales, effort);
    enlarge_answers(finest, rows, cols);
  }
  for (Direction& direction : directions_)
    for (Image<float>& picture : direction.room) pool_.scratch().release(picture);
  for (Pyramid& pyramid : pyramids_)
    for (Level& level : pyramid) pool_.scratch().release(level.planes);
}

// What each direction is asked for.
void CpuFlow::ask(const FlowRequest& request) {
  auto& [there, back] = directions_;
  there.from = &pyramids_[0], there.to = &pyramids_[1];
  there.start = request.start_a_to_b, there.answer = request.a_to_b;
  back.from = &pyramids_[1], back.to = &pyramids_[0];
  back.start = request.start_b_to_a, back.answer = request.b_to_a;
}

CpuFlow::Level& CpuFlow::level_of(Pyramid& pyramid, int scale) {
  if (pyramid.size() <= static_cast<std::size_t>(scale)) pyramid.resize(static_cast<std::size_t>(scale) + 1);
  return pyramid[static_cast<std::size_t>(scale)];
}

// The scales that are matched, from a picture of full size, and those between.
void CpuFlow::build(const Image<float>& picture, int finest, int coarsest, Pyramid& pyramid) {
  for (int scale = std::min(finest, 1); scale <= coarsest; ++scale) {
    Level& level = pyramid[static_cast<std::size_t>(scale)];
    const int rows = picture.rows() >> scale, cols = picture.cols() >> scale;
    const auto origin = [&](int plane) { return level.planes.row(plane, kFlowBorder) + kFlowBorder; };
    float *gray = origin(0), *dx = origin(1), *dy = origin(2);
    const std::ptrdiff_t pitch = level.planes.cols();
    if (scale == 0) {
      for (int y = 0; y < rows; ++y) std::copy_n(picture.row(0, y), cols, gray + y * pitch);
    } else if (scale == 1 && finest > 0) {
      kernels_.halve(picture.plane(0), picture.cols(), rows, cols, gray, pitch);
    } else {
      const FlowPicture& finer = pyramid[static_cast<std::size_t>(scale - 1)].picture;
      kernels_.halve(finer.gray, finer.pitch, rows, cols, gray, pitch);
    }
    level.picture = {gray, dx, dy, pitch, rows, cols};
    if (scale < finest) continue;
    kernels_.extend(gray, pitch, rows, cols);
    kernels_.derive(gray, pitch, rows, cols, dx, dy);
  }
}

// Both directions at one scale: the patches, the flow that they spread, its refinement.
void CpuFlow::match(int scale, const FlowScales& scales, const FlowEffort& effort) {
  pool_.for_each(
      2, [&](int i) { prepare(directions_[static_cast<std::size_t>(i)], scale, scales.coarsest, effort); });
  search();
  if (scale == scales.far) search_far();
  const int rows = directions_[0].search.from.rows;
  for (Direction& direction : directions_)
    pool_.for_rows(rows, [&](int y0, int y1) {
      kernels_.spread(direction.search, y0, y1, planes_of(direction.flow), direction.weight.plane(0));
    });
  pool_.for_each(2, [&](int i) { refine(directions_[static_cast<std::size_t>(i)], scale, effort); });
}

void CpuFlow::search() {
  using flow_constants::kStrip;
  const int patch_rows = directions_[0].search.grid.rows;
  const int strips = (patch_rows + kStrip - 1) / kStrip;
  pool_.for_each(2 * strips, [&](int i) {
    const int first = i / 2 * kStrip;
    kernels_.search(directions_[static_cast<std::size_t>(i % 2)].search, first,
                    std::min(first + kStrip, patch_rows));
  });
}

// What is found far away in either direction is a guess in both, which a second search spreads over the rest
// of the object.
void CpuFlow::search_far() {
  const PatchGrid grid = directions_[0].search.grid;
  for (Direction& direction : directions_) {
    direction.far.reshape_like(direction.patches), direction.far_back.reshape_like(direction.patches);
    direction.far_back.fill(kNowhere);
  }
  pool_.for_each(2 * grid.rows, [&](int i) {
    Direction& direction = directions_[static_cast<std::size_t>(i % 2)];
    const FlowPicture& picture = direction.search.from;
    kernels_.search_far(direction.search,
                        {far_reach(picture.cols), far_reach(picture.rows), planes_of(direction.far)}, i / 2,
                        i / 2 + 1);
  });
  auto& [there, back] = directions_;
  if (keep_agreeing(there.far, there.agreed) + keep_agreeing(back.far, back.agreed) == 0) return;
  take_far(there.agreed, there.search, back.far_back);
  take_far(back.agreed, back.search, there.far_back);
  for (Direction& direction : directions_) {
    PatchSearch& search = direction.search;
    search.start_u = search.start_v = nullptr;
    search.other_u = direction.far_back.plane(0), search.other_v = direction.far_back.plane(1);
  }
  search();
}

// The guesses of this scale's patches: what is given, and what the coarser scale found. Where the picture is
// clipped only the latter, which comes from the surroundings: what is given could never be refuted.
void CpuFlow::prepare(Direction& d, int scale, int coarsest, const FlowEffort& effort) {
  const auto at = static_cast<std::size_t>(scale);
  const FlowPicture &from = (*d.from)[at].picture, &to = (*d.to)[at].picture;
  const PatchGrid grid = patch_grid(from.rows, from.cols, effort.stride);
  const bool guided = d.start.vectors != nullptr, begins = scale == coarsest;
  d.patches.reshape(2, grid.rows, grid.cols);
  if (guided) d.starts.reshape_like(d.patches);
  const float shrink = 1 / static_cast<float>(1 << scale);
  for (int row = 0; row < grid.rows; ++row)
    for (int col = 0; col < grid.cols; ++col) {
      const int y = std::min(row * grid.stride, from.rows - kPatchSize) + kPatchSize / 2;
      const int x = std::min(col * grid.stride, from.cols - kPatchSize) + kPatchSize / 2;
      Offset given;
      if (guided) given = guess_at(d.start, x << scale, y << scale);
      const bool clipped = from.gray[y * from.pitch + x] >= clip_policy::kMotionShare.brightest;
      for (int c = 0; c < 2; ++c) {
        const float here = shrink * (c == 0 ? given.x : given.y);
        const float found =
            begins ? here
                   : 2 * d.flow.at(c, std::min(y / 2, d.flow.rows() - 1), std::min(x / 2, d.flow.cols() - 1));
        d.patches.at(c, row, col) = found;
        if (guided) d.starts.at(c, row, col) = clipped ? found : here;
      }
    }
  d.flow.reshape(2, from.rows, from.cols);
  d.weight.reshape(1, from.rows, from.cols);
  d.search = {from, to, grid, planes_of(d.patches), effort.steps};
  if (guided && !begins) d.search.start_u = d.starts.plane(0), d.search.start_v = d.starts.plane(1);
}

void CpuFlow::refine(Direction& d, int scale, const FlowEffort& effort) {
  using namespace flow_constants;
  const auto at = static_cast<std::size_t>(scale);
  FlowRefinement refinement{
      (*d.from)[at].picture, (*d.to)[at].picture, planes_of(d.flow), {},           kPictures,
      kLeastSlope2,          kSmallest,           effort.rounds,     effort.sweeps};
  for (std::size_t i = 0; i < d.room.size(); ++i) refinement.room[i] = d.room[i].plane(0);
  refinement_kernels().refine(refinement);
}

// From the flows of the finest scale that was matched to those of full size.
void CpuFlow::enlarge_answers(int finest, int rows, int cols) {
  auto& [there, back] = directions_;
  if (finest == 0) {
    for (Direction& direction : directions_) std::swap(direction.flow, *direction.answer);
    return;
  }
  for (int scale = finest; scale > 1; --scale) {
    const ScratchLease larger(pool_.scratch(), rows >> (scale - 1), cols >> (scale - 1),
                              {{&there.larger, 2}, {&back.larger, 2}});
    pool_.for_each(2, [&](int i) {
      Direction& direction = directions_[static_cast<std::size_t>(i)];
      enlarge(direction.flow, direction.line, direction.larger);
      std::swap(direction.flow, direction.larger);
    });
  }
  pool_.for_each(2, [&](int i) {
    Direction& direction = directions_[static_cast<std::size_t>(i)];
    enlarge(direction.flow, direction.line, *direction.answer);
  });
}

// To the size of the answer, which is twice that of the flow, perhaps with an odd last row or column.
void CpuFlow::enlarge(const Image<float>& flow, std::vector<float>& line, Image<float>& answer) {
  const int rows = flow.rows(), cols = flow.cols();
  line.resize(static_cast<std::size_t>(cols) + 2);  // a column more on both sides
  for (int c = 0; c < 2; ++c)
    for (int y = 0; y < answer.rows(); ++y) {
      const int near = std::min(y / 2, rows - 1);
      const int far = std::clamp(y / 2 + (y % 2 == 0 ? -1 : 1), 0, rows - 1);
      const float *a = flow.row(c, near), *b = flow.row(c, far);
      float *l = line.data() + 1, *out = answer.row(c, y);
      for (int x = 0; x < cols; ++x) l[x] = 1.5f * a[x] + 0.5f * b[x];  // twice: pixels become half as large
      l[-1] = l[0], l[cols] = l[cols - 1];
      for (int x = 0; x < cols; ++x) {
        out[2 * x] = 0.75f * l[x] + 0.25f * l[x - 1];
        out[2 * x + 1] = 0.75f * l[x] + 0.25f * l[x + 1];
      }
      if (answer.cols() > 2 * cols) out[2 * cols] = l[cols];
    }
}

}  // namespace hdrcam
