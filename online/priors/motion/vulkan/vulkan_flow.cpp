#include "online/priors/motion/vulkan/vulkan_flow.h"

#include <spdlog/spdlog.h>

#include "online/priors/motion/far_patches.h"

namespace hdrcam {
namespace {

constexpr int kDirectionPlanes = kFlowVectorPlanes / 2;

// Of both directions, in the first samples of `there`.
void upload_vectors(GpuWork& work, const std::array<Image<float>, 2>& here, const GpuBuffer& there) {
  std::size_t at = 0;
  for (const Image<float>& vectors : here) {
    const auto bytes = std::as_bytes(vectors.samples());
    work.upload(bytes, there, at);
    at += bytes.size();
  }
}
void download_vectors(GpuWork& work, const GpuBuffer& there, const PatchGrid& grid,
                      std::array<Image<float>, 2>& here) {
  std::size_t at = 0;
  for (Image<float>& vectors : here) {
    vectors.reshape(kDirectionPlanes, grid.rows, grid.cols);
    const auto bytes = std::as_writable_bytes(vectors.samples());
    work.download(there, at, bytes);
    at += bytes.size();
  }
}

}  // namespace

Result<VulkanFlow::Room> VulkanFlow::Room::make(GpuDevice& device, int rows, int cols) {
  const auto picture = [&](int planes) { return GpuPicture::make(device, planes, rows, cols); };
  const FlowEffort effort = effort_of(FlowQuality::Fine);
  const PatchGrid grid = patch_grid(rows, cols, effort.stride);  // the largest
  const auto patches = [&] { return GpuPicture::make(device, kFlowVectorPlanes, grid.rows, grid.cols); };
  Room room;
  room.passes = TRY(FlowPasses::make(device));
  room.guess = TRY(picture(kFlowVectorPlanes));
  room.flow = TRY(picture(kFlowVectorPlanes));
  room.before = TRY(picture(kFlowVectorPlanes));
  room.next = TRY(picture(kFlowVectorPlanes));
  room.patches = TRY(patches());
  room.starts = TRY(patches());
  room.others = TRY(patches());
  room.data = TRY(picture(kFlowDataPlanes));
  room.system = TRY(picture(kFlowSystemPlanes));
  for (int scale = 0; scale <= scales_of(effort, rows, cols).coarsest; ++scale)
    room.levels.push_back(TRY(GpuPicture::make(device, kFlowLevelPlanes, rows >> scale, cols >> scale)));
  return room;
}

VulkanFlow::VulkanFlow(int rows, int cols, WorkerPool& pool, GpuDevice& device)
    : rows_(rows), cols_(cols), pool_(pool), device_(device) {
  if (rows < kMinSize || cols < kMinSize) return;  // there is no flow to find
  auto room = [&] {
    const GpuTurn turn(device_);
    return Room::make(device, rows, cols);
  }();
  if (room)
    room_.emplace(std::move(*room));
  else
    fall_back_to_cpu(room.error());
}

VulkanFlow::~VulkanFlow() {
  const GpuTurn turn(device_);
  room_.reset();
}

void VulkanFlow::fall_back_to_cpu(const Error& why) {
  fallback_reason_ = fmt::format("{}: {}", device_.facts().name, why.message);
  spdlog::warn("the flow goes on with the processor: {}", fallback_reason_);
  const GpuTurn turn(device_);
  room_.reset();
  processor_.emplace(pool_);
}

void VulkanFlow::compute(FlowQuality quality, const FlowRequest& request) {
  HDRCAM_CHECK(request.a->rows() == rows_ && request.a->cols() == cols_);
  if (!processor_) {
    const Result<void> done = compute_gpu(quality, request);
    if (done) return;
    fall_back_to_cpu(done.error());
  }
  processor_->compute(quality, request);
}

Result<void> VulkanFlow::compute_gpu(FlowQuality quality, const FlowRequest& request) {
  const int rows = rows_, cols = cols_;
  for (Image<float>* flow : {request.a_to_b, request.b_to_a}) flow->reshape(kDirectionPlanes, rows, cols);
  if (!room_) {
    request.a_to_b->fill(0), request.b_to_a->fill(0);
    return {};
  }
  const GpuTurn turn(device_, &pool_);
  Room& on = *room_;
  GpuWork& work = device_.work();
  const FlowEffort effort = effort_of(quality);
  const FlowScales scales = scales_of(effort, rows, cols);

  upload(work, *request.a, on.levels[0]);
  upload(work, *request.b, on.levels[0], kFlowLevelPlanes / 2);
  const GpuFlowGuess guess = upload_guess(request);
  const auto level_of = [&](int scale) -> const GpuPicture& {
    return on.levels[static_cast<std::size_t>(scale)];
  };
  for (int scale = 1; scale <= scales.coarsest; ++scale)
    on.passes.halve(level_of(scale - 1), level_of(scale));
  for (int scale = scales.finest; scale <= scales.coarsest; ++scale) on.passes.derive(level_of(scale));

  const GpuFlow none{**on.flow, 0, 0};
  for (int scale = scales.coarsest; scale >= scales.finest; --scale) {
    const GpuPicture& pictures = level_of(scale);
    const GpuFlowLevel level{pictures, patch_grid(pictures.rows, pictures.cols, effort.stride), scale};
    const bool begins = scale == scales.coarsest;
    const auto guided = [&](std::size_t d) { return guess.directions[d].given && !begins; };
    const GpuFlow coarser = begins ? none : GpuFlow{**on.flow, rows >> (scale + 1), cols >> (scale + 1)};
    on.passes.start(level, guess, coarser, **on.patches, **on.starts);
    on.passes.search(level, effort.steps, {guided(0), guided(1)}, **on.starts, nullptr, **on.patches);
    if (scale == scales.far) TRY(search_far(level, effort.steps));
    on.passes.spread(level, **on.patches, **on.flow);
    refine(pictures, effort);
  }
  for (int scale = scales.finest; scale > 0; --scale) {
    on.passes.enlarge({**on.flow, rows >> scale, cols >> scale},
                      {**on.next, rows >> (scale - 1), cols >> (scale - 1)});
    std::swap(on.flow, on.next);
  }
  download(work, on.flow, 0, kDirectionPlanes, *request.a_to_b);
  download(work, on.flow, kDirectionPlanes, kDirectionPlanes, *request.b_to_a);
  return work.finish();
}

// One upload where both directions start at the same vectors.
GpuFlowGuess VulkanFlow::upload_guess(const FlowRequest& request) {
  GpuFlowGuess guess{room_->guess, {}};
  const std::array<const FlowGuess*, 2> given{&request.start_a_to_b, &request.start_b_to_a};
  for (std::size_t d = 0; d < 2; ++d) {
    const bool again = d == 1 && given[1]->vectors == given[0]->vectors;
    const int first = d == 1 && !again ? kDirectionPlanes : 0;
    guess.directions[d] = {given[d]->vectors != nullptr, given[d]->carried, first, given[d]->scale};
    if (given[d]->vectors != nullptr && !again)
      upload(device_.work(), *given[d]->vectors, room_->guess, first);
  }
  return guess;
}

// As CpuFlow's. Which of the far patches are believed is decided on the processor, with its code: there are
// few patches at this scale.
Result<void> VulkanFlow::search_far(const GpuFlowLevel& level, int steps) {
  Room& on = *room_;
  GpuWork& work = device_.work();
  on.passes.search_far(level, **on.patches, **on.others);
  download_vectors(work, **on.others, level.grid, far_);
  download_vectors(work, **on.patches, level.grid, found_);
  TRY(work.finish());
  if (keep_agreeing(far_[0], agreed_[0]) + keep_agreeing(far_[1], agreed_[1]) == 0) return {};
  for (Image<float>& back : far_back_) {
    back.reshape(kDirectionPlanes, level.grid.rows, level.grid.cols);
    back.fill(kNowhere);
  }
  for (std::size_t d = 0; d < 2; ++d) {
    PatchSearch search{};
    search.from.rows = level.pictures.rows, search.from.cols = level.pictures.cols;
    search.grid = level.grid, search.patches = {found_[d].plane(0), found_[d].plane(1)};
    take_far(agreed_[d], search, far_back_[1 - d]);
  }
  upload_vectors(work, found_, **on.patches);
  upload_vectors(work, far_back_, **on.others);
  on.passes.search(level, steps, {false, false}, **on.starts, *on.others, **on.patches);
  return {};
}

void VulkanFlow::refine(const GpuPicture& level, const FlowEffort& effort) {
  Room& on = *room_;
  on.passes.linearise(level, **on.flow, **on.data);
  std::swap(on.flow, on.before);
  const GpuBuffer* now = *on.before;
  for (int round = 0; round < effort.rounds; ++round) {
    on.passes.weigh(level, **on.data, **on.before, *now, **on.system);
    for (int i = 0; i < effort.sweeps; ++i) {
      on.passes.sweep(level, **on.system, *now, **on.next);
      std::swap(on.flow, on.next);
      now = *on.flow;
    }
  }
}

}  // namespace hdrcam
