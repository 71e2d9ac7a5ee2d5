#include "online/state/vulkan/vulkan_state.h"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace hdrcam {
namespace {

void upload_both(GpuWork& work, const Image<float>& first, const Image<float>& second,
                 const GpuPicture& both) {
  upload(work, first, both);
  upload(work, second, both, first.channels());
}

void download_both(GpuWork& work, const GpuPicture& both, Image<float>& first, Image<float>& second) {
  download(work, both, 0, 3, first);
  download(work, both, 3, 3, second);
}

}  // namespace

Result<VulkanState::Room> VulkanState::Room::make(GpuDevice& device, const StateOptions& options, int rows,
                                                  int cols) {
  const auto picture = [&](int planes) { return GpuPicture::make(device, planes, rows, cols); };
  Room room;
  room.passes = TRY(StatePasses::make(device, options));
  room.tables = TRY(GpuTables::make(device));
  room.state = TRY(picture(kStatePlanes));
  room.predicted = TRY(picture(kStatePlanes));
  room.joined = TRY(picture(kStatePlanes));
  room.samples = TRY(picture(kSamplePlanes));
  room.motion = TRY(picture(kMotionPlanes));
  room.path = TRY(picture(kMotionPlanes));
  room.longer = TRY(picture(kMotionPlanes));
  room.seen = TRY(picture(3));
  room.brightest = TRY(picture(3));
  room.room = TRY(PassRoom::make(device, rows, cols));
  room.contrast = TRY(picture(3));
  room.gate = TRY(picture(1));
  room.share = TRY(picture(1));
  room.residuals =
      TRY(GpuPicture::make(device, kResidualPlanes, std::max(1, kResidualSampling.lines(rows, cols)),
                           std::max(1, kResidualSampling.pixels_of_line(cols))));
  for (HeldCodes& held : room.held) held.codes = TRY(picture(3));
  return room;
}

VulkanState::VulkanState(const StateOptions& options, int rows, int cols, WorkerPool& pool, GpuDevice& device)
    : options_(options), rows_(rows), cols_(cols), pool_(pool), device_(device) {
  known_.radiance = Image<float>(3, rows, cols);
  known_.variance = Image<float>(3, rows, cols);
  known_.own_share = Image<float>(1, rows, cols);
  auto room = [&] {
    const GpuTurn turn(device_);
    return Room::make(device, options, rows, cols);
  }();
  if (room)
    room_.emplace(std::move(*room));
  else
    fall_back_to_cpu(room.error());
}

VulkanState::~VulkanState() {
  const GpuTurn turn(device_);
  room_.reset();
}

CpuState& VulkanState::fall_back_to_cpu(const Error& why) {
  fallback_reason_ = fmt::format("{}: {}", device_.facts().name, why.message);
  spdlog::warn("the state goes on with the processor: {}", fallback_reason_);
  {
    const GpuTurn turn(device_);
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

void VulkanState::join(const RadianceEstimate& of, std::span<const LaterFrame> later, float unseen_variance,
                       JoinedState& joined) {
  HDRCAM_CHECK(!later.empty());
  if (processor_) return processor_->join(of, later, unseen_variance, joined);
  if (const Result<void> done = join_gpu(of, later, unseen_variance, joined); !done) {
    // `of` may be our own copy, which goes on living
    fall_back_to_cpu(done.error()).join(of, later, unseen_variance, joined);
  }
}

// Until the next call.
const GpuPicture& VulkanState::codes_of(const ExposedFrame& frame) {
  auto& held = room_->held;
  for (const HeldCodes& known : held)
    if (known.frame == frame.index) return known.codes;
  HeldCodes& oldest = *std::min_element(
      held.begin(), held.end(), [](const HeldCodes& a, const HeldCodes& b) { return a.frame < b.frame; });
  upload(device_.work(), frame.codes, oldest.codes);
  oldest.frame = frame.index;
  return oldest.codes;
}

void VulkanState::upload_motion(const FlowField& motion) {
  upload_both(device_.work(), motion.vectors, motion.confidence, room_->motion);
}

Result<void> VulkanState::restart_gpu(const StateInput& input) {
  const GpuTurn turn(device_, &pool_);
  residuals_ = SampleResiduals();
  Room& on = *room_;
  GpuWork& work = device_.work();
  for (HeldCodes& held : on.held) held.frame = -1;
  const GpuPicture& codes = codes_of(input.frame);
  on.tables.take(input.tables, work);
  Image<float> unseen(3, rows_, cols_);
  unseen.fill(kUnseenVariance);
  on.passes.sample(codes, codes, on.tables, on.samples);
  // the samples' radiance, with nothing known of it, is the first state
  Image<float> radiance;
  download(work, on.samples, 0, 3, radiance);
  TRY(work.finish());
  upload_both(work, radiance, unseen, on.state);
  on.passes.update({on.state, on.samples, on.tables, input.unseen_variance}, on.room, on.share,
                   SampleOrder::FirstFrame);
  download_known(on.state);
  return work.finish();
}

// With finish(): until then what was known stays.
void VulkanState::download_known(const GpuPicture& state) {
  download_both(device_.work(), state, known_.radiance, known_.variance);
  download(device_.work(), room_->share, known_.own_share);
}

Result<void> VulkanState::advance_gpu(const StateInput& input, const FlowField& to_previous) {
  const GpuTurn turn(device_, &pool_);
  Room& on = *room_;
  const StatePasses& passes = on.passes;
  GpuWork& work = device_.work();
  const GpuPicture& codes = codes_of(input.frame);
  upload_motion(to_previous);
  on.tables.take(input.tables, work);
  passes.sample(codes, codes, on.tables, on.samples);
  passes.warp_state(on.state, on.motion, on.room, on.predicted);
  passes.model_blur(on.predicted, on.motion, input.blur_fraction(), on.samples);
  const GpuSeen seen{on.predicted, on.samples, on.tables, input.unseen_variance};
  passes.gate(seen, on.motion, on.room, on.gate, on.contrast);
  passes.age(seen, {on.contrast, on.motion}, on.gate);
  const bool judges = rows_ > 2 && cols_ > 2;
  if (judges) passes.residuals(seen, on.motion, on.residuals);
  passes.update(seen, on.room, on.share);
  download_known(on.predicted);
  if (judges) download(work, on.residuals, found_);
  TRY(work.finish());
  std::swap(on.state, on.predicted);
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

Result<void> VulkanState::join_gpu(const RadianceEstimate& of, std::span<const LaterFrame> later,
                                   float unseen_variance, JoinedState& joined) {
  const GpuTurn turn(device_, &pool_);
  Room& on = *room_;
  const StatePasses& passes = on.passes;
  GpuWork& work = device_.work();
  if (&of == static_cast<const RadianceEstimate*>(&known_)) {
    work.copy(*on.state.buffer, *on.joined.buffer);
  } else {
    upload_both(work, of.radiance, of.variance, on.joined);
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
    const GpuPicture& codes = codes_of(*ahead.frame);
    on.tables.take(*ahead.tables, work);
    passes.warp(codes, on.path, on.seen);
    passes.largest_around(codes, on.path, on.brightest);
    passes.sample(on.seen, on.brightest, on.tables, on.samples);
    passes.model_blur(on.joined, on.path, blur_of_path(later.first(static_cast<std::size_t>(intervals))),
                      on.samples);
    const GpuSeen seen{on.joined, on.samples, on.tables, unseen_variance};
    passes.gate(seen, on.path, on.room, on.gate, on.contrast);
    passes.join(seen, on.gate, {on.contrast, on.path, intervals, ahead.shorter}, on.room, on.share);
  }
  download_both(work, on.joined, joined.radiance, joined.variance);
  download(work, on.share, joined.later_share);
  return work.finish();
}

}  // namespace hdrcam
