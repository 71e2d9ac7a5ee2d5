#include "online/state/vulkan/vulkan_state.h"

#include <spdlog/spdlog.h>

namespace hdrcam {
namespace {

constexpr int kCubic = 3;  // planes of a state that are carried by cubic convolution: its radiance

// [a; b] along the channels.
void stack(const Image<float>& a, const Image<float>& b, Image<float>& both) {
  both.reshape(a.channels() + b.channels(), a.rows(), a.cols());
  std::copy(a.samples().begin(), a.samples().end(), both.samples().begin());
  std::copy(b.samples().begin(), b.samples().end(), both.plane(a.channels()));
}

void split(const Image<float>& both, Image<float>& radiance, Image<float>& variance) {
  for (Image<float>* half : {&radiance, &variance}) half->reshape(3, both.rows(), both.cols());
  std::copy_n(both.plane(0), radiance.size(), radiance.plane(0));
  std::copy_n(both.plane(3), variance.size(), variance.plane(0));
}

}  // namespace

Result<VulkanState::Room> VulkanState::Room::make(GpuDevice& device, const StateOptions& options, int rows,
                                                  int cols) {
  const auto picture = [&](int planes) { return GpuPicture::make(device, planes, rows, cols); };
  const int lines = kResidualSampling.line_step_px(rows, cols);
  return Room{
      .passes = TRY(StatePasses::make(device, options)),
      .tables = TRY(GpuTables::make(device)),
      .state = TRY(picture(kStatePlanes)),
      .predicted = TRY(picture(kStatePlanes)),
      .joined = TRY(picture(kStatePlanes)),
      .samples = TRY(picture(kSamplePlanes)),
      .motion = TRY(picture(kMotionPlanes)),
      .path = TRY(picture(kMotionPlanes)),
      .longer = TRY(picture(kMotionPlanes)),
      .codes = TRY(picture(3)),
      .seen = TRY(picture(3)),
      .largest = TRY(picture(3)),
      .brightest = TRY(picture(3)),
      .room = TRY(PassRoom::make(device, rows, cols)),
      .contrast = TRY(picture(3)),
      .gate = TRY(picture(1)),
      .share = TRY(picture(1)),
      .residuals = TRY(GpuPicture::make(device, kResidualPlanes, std::max(1, (rows - 2 + lines - 1) / lines),
                                        std::max(1, (cols - 1) / 2)))};
}

VulkanState::VulkanState(const StateOptions& options, int rows, int cols, WorkerPool& pool, GpuDevice& device)
    : options_(options), rows_(rows), cols_(cols), pool_(pool), device_(device) {
  known_.radiance = Image<float>(3, rows, cols);
  known_.variance = Image<float>(3, rows, cols);
  known_.own_share = Image<float>(1, rows, cols);
  auto room = [&] {
    const std::lock_guard turn(device_.turn());
    return Room::make(device, options, rows, cols);
  }();
  if (room)
    room_.emplace(std::move(*room));
  else
    fall_back_to_cpu(room.error());
}

VulkanState::~VulkanState() {
  const std::lock_guard turn(device_.turn());
  room_.reset();
}

CpuState& VulkanState::fall_back_to_cpu(const Error& why) {
  fallback_reason_ = fmt::format("{}: {}", device_.facts().name, why.message);
  spdlog::warn("the state goes on with the processor: {}", fallback_reason_);
  {
    const std::lock_guard turn(device_.turn());
    room_.reset();
  }
  processor_ = std::make_unique<CpuState>(options_, rows_, cols_, pool_);
  processor_->resume(known_, residuals_);
  return *processor_;
}

void VulkanState::forget_residuals() {
  if (processor_) processor_->forget_residuals();
  residuals_ = SampleResiduals();
}

void VulkanState::restart(const StateInput& input) {
  if (processor_) return processor_->restart(input);
  if (const Result<void> done = restart_gpu(input); !done) fall_back_to_cpu(done.error()).restart(input);
}

void VulkanState::advance(const StateInput& input, const FlowField& to_previous) {
  if (processor_) return processor_->advance(input, to_previous);
  if (const Result<void> done = advance_gpu(input, to_previous); !done)
    fall_back_to_cpu(done.error()).advance(input, to_previous);
}

void VulkanState::join(const RadianceState& of, std::span<const LaterFrame> later, float white,
                       JoinedState& joined) {
  if (processor_) return processor_->join(of, later, white, joined);
  if (const Result<void> done = join_gpu(of, later, white, joined); !done) {
    // `of` may be our own copy, which goes on living
    fall_back_to_cpu(done.error()).join(of, later, white, joined);
  }
}

void VulkanState::upload_motion(const FlowField& motion) {
  stack(motion.vectors, motion.confidence, stacked_);
  upload(device_.work(), stacked_, room_->motion);
}

Result<void> VulkanState::restart_gpu(const StateInput& input) {
  const std::lock_guard turn(device_.turn());
  residuals_ = SampleResiduals();
  Room& on = *room_;
  GpuWork& work = device_.work();
  upload(work, input.frame.codes, on.codes);
  on.tables.take(input.tables, work);
  Image<float> unseen(3, rows_, cols_);
  unseen.fill(kUnseenVariance);
  on.passes.sample(on.codes, on.codes, on.tables, on.samples);
  // the samples' radiance, with nothing known of it, is the first state
  download(work, on.samples, fetched_);
  TRY(work.finish());
  Image<float> radiance(3, rows_, cols_);
  std::copy_n(fetched_.plane(0), radiance.size(), radiance.plane(0));
  stack(radiance, unseen, stacked_);
  upload(work, stacked_, on.state);
  on.passes.update({on.state, on.samples, on.tables, input.white}, on.room, on.share,
                   SampleOrder::FirstFrame);
  download(work, on.state, fetched_);
  download(work, on.share, fetched_share_);
  TRY(work.finish());
  take_state();
  return {};
}

void VulkanState::take_state() {
  split(fetched_, known_.radiance, known_.variance);
  known_.own_share.copy_from(fetched_share_);
}

Result<void> VulkanState::advance_gpu(const StateInput& input, const FlowField& to_previous) {
  const std::lock_guard turn(device_.turn());
  Room& on = *room_;
  const StatePasses& passes = on.passes;
  GpuWork& work = device_.work();
  upload(work, input.frame.codes, on.codes);
  upload_motion(to_previous);
  on.tables.take(input.tables, work);
  passes.sample(on.codes, on.codes, on.tables, on.samples);
  passes.warp(on.state, on.motion, kCubic, options_.ringing_limit, on.predicted);
  passes.model_blur(on.predicted, on.motion, input.blur_fraction(), on.samples);
  const GpuSeen seen{on.predicted, on.samples, on.tables, input.white};
  passes.gate(seen, on.motion, on.room, on.gate, on.contrast);
  passes.age(seen, {on.contrast, on.motion}, on.gate);
  const bool judges = rows_ > 2 && cols_ > 2;
  if (judges) passes.residuals(seen, on.motion, on.residuals);
  passes.update(seen, on.room, on.share);
  download(work, on.predicted, fetched_);
  download(work, on.share, fetched_share_);
  if (judges) download(work, on.residuals, found_);
  TRY(work.finish());
  std::swap(on.state, on.predicted);
  take_state();
  if (judges) learn_residuals(input.tables.exposure());
  return {};
}

void VulkanState::learn_residuals(float exposure) {
  residuals_.begin();
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < found_.plane_size(); ++i)
      if (const float bin = found_.plane(6 + c)[i]; bin >= 0)
        residuals_.take(c, static_cast<int>(bin), found_.plane(c)[i], found_.plane(3 + c)[i]);
  residuals_.learn(exposure);
}

Result<void> VulkanState::join_gpu(const RadianceState& of, std::span<const LaterFrame> later, float white,
                                   JoinedState& joined) {
  const std::lock_guard turn(device_.turn());
  if (later.empty()) {
    joined.copy_from(of);
    joined.later_share.reshape(1, rows_, cols_);
    joined.later_share.fill(0);
    return {};
  }
  Room& on = *room_;
  const StatePasses& passes = on.passes;
  GpuWork& work = device_.work();
  if (&of == &known_) {
    work.copy(*on.state.buffer, *on.joined.buffer);
  } else {
    stack(of.radiance, of.variance, stacked_);
    upload(work, stacked_, on.joined);
  }
  work.clear(*on.share.buffer);
  int intervals = 0;
  for (const LaterFrame& ahead : later) {
    intervals += 1;
    upload_motion(*ahead.from_previous);
    if (intervals == 1) {
      work.copy(*on.motion.buffer, *on.path.buffer);
    } else {
      passes.follow(on.motion, on.path, on.longer);
      std::swap(on.path, on.longer);
    }
    upload(work, ahead.frame->codes, on.codes);
    on.tables.take(*ahead.tables, work);
    passes.warp(on.codes, on.path, kCubic, 0, on.seen);
    passes.dilate(on.codes, on.largest);
    passes.warp(on.largest, on.path, 0, 0, on.brightest);
    passes.sample(on.seen, on.brightest, on.tables, on.samples);
    // the path spans all intervals, the exposure lasts a part of the last one
    passes.model_blur(on.joined, on.path, ahead.frame->blur_fraction / static_cast<float>(intervals),
                      on.samples);
    const GpuSeen seen{on.joined, on.samples, on.tables, white};
    passes.gate(seen, on.path, on.room, on.gate, on.contrast);
    passes.join(seen, on.gate, {on.contrast, on.path, intervals}, on.room, on.share);
  }
  download(work, on.joined, fetched_);
  download(work, on.share, joined.later_share);
  TRY(work.finish());
  split(fetched_, joined.radiance, joined.variance);
  joined.own_share.copy_from(of.own_share);
  return {};
}

}  // namespace hdrcam
