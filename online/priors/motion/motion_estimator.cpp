#include "online/priors/motion/motion_estimator.h"

#include <algorithm>
#include <utility>

#include "capture/clip_policy.h"
#include "capture/clipped_pixel.h"
#include "online/pictures/copy_in_parallel.h"
#include "online/pictures/local_statistics.h"
#include "online/pictures/picture_kernels.h"
#include "online/priors/motion/clipped_motion_kernels.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/state/exposure_blur.h"
#include "online/state/fusion_kernels.h"

namespace hdrcam {
namespace {

// The channels count alike: in a dark frame only one of them may show anything.
float to_gray(float r, float g, float b) { return (r + g + b) * (1 / 3.f); }

void gray_of_frame(const ExposedFrame& frame, Image<float>& gray, WorkerPool& pool) {
  const auto& codes = frame.codes;
  gray.reshape(1, codes.rows(), codes.cols());
  pool.for_rows(codes.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float *r = codes.row(0, y), *g = codes.row(1, y), *b = codes.row(2, y);
      float* out = gray.row(0, y);
      for (int x = 0; x < codes.cols(); ++x) out[x] = to_gray(r[x], g[x], b[x]);
    }
  });
}

// The state as the camera would have recorded it at this exposure. blur: what is added to it, or null.
void gray_of_state(const Image<float>& radiance, const Image<float>* blur, const ExposureTables& tables,
                   Image<float>& gray, WorkerPool& pool) {
  gray.reshape(1, radiance.rows(), radiance.cols());
  pool.for_rows(radiance.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      RecordedRow row{
          .radiance = {}, .blur = {}, .codes = {}, .exposure = tables.exposure(), .gray = gray.row(0, y)};
      for (int c = 0; c < 3; ++c) {
        row.radiance[c] = radiance.row(c, y);
        if (blur != nullptr) row.blur[c] = blur->row(c, y);
        row.codes[c] = tables.codes(c).data();
      }
      fusion_kernels().record(row, radiance.cols());
    }
  });
}

// 1 where all channels of a row are clipped, bright or dark, 0 elsewhere.
void mark_clipped(const Image<float>& codes, int y, const clip_policy::UsableCodes& usable, float* clipped) {
  const float *r = codes.row(0, y), *g = codes.row(1, y), *b = codes.row(2, y);
  for (int x = 0; x < codes.cols(); ++x)
    clipped[x] = clip_policy::all_clipped(r[x], g[x], b[x], usable) ? 1.f : 0.f;
}

// Forward-backward agreement becomes the flow's confidence. frame: at the flow's pixels, where it is clipped
// some confidence is assumed; or null.
void rate_flow(FlowField& flow, const FlowField& back, const ExposedFrame* frame, WorkerPool& pool) {
  const clip_policy::UsableCodes usable = clip_policy::kMotionRating;
  constexpr float kClippedConfidence = 0.5f;  // assumed where agreement cannot be measured
  const int rows = flow.vectors.rows(), cols = flow.vectors.cols();
  flow.confidence.reshape(1, rows, cols);
  pool.for_rows(rows, [&](int y0, int y1) {
    flow_kernels().rate({.there = flow.vectors.plane(0),
                         .back = back.vectors.plane(0),
                         .rows = rows,
                         .cols = cols,
                         .y0 = y0,
                         .y1 = y1,
                         .codes = frame != nullptr ? frame->codes.plane(0) : nullptr,
                         .darkest = usable.darkest,
                         .brightest = usable.brightest,
                         .assumed = kClippedConfidence,
                         .confidence = flow.confidence.plane(0)});
  });
}

// Whether two steps, one of which takes `ratio` times as long as the other, say how a motion changes.
bool tells_change(float ratio) {
  constexpr float kMostRatio = 3;  // beyond, the error of the shorter one's motion is most of what differs
  return ratio > 1 / kMostRatio && ratio < kMostRatio;
}

// A row's motion, no longer than `longest` along either axis. Where nothing is seen a search answers with its
// guess, which the ratio of the next step's time makes longer: without a limit that goes on to infinity. What
// is no number becomes a limit, too.
void limit(float* motion, int n, float longest) {
  for (int x = 0; x < n; ++x) motion[x] = std::min(longest, std::max(-longest, motion[x]));
}

}  // namespace

MotionEstimator::MotionEstimator(int rows, int cols, WorkerPool& pool, GpuDevice* gpu)
    : rows_(rows),
      cols_(cols),
      pool_(pool),
      flow_(make_dense_flow(rows, cols, pool, gpu)),
      shake_(rows, cols),
      bridge_error_(rows, cols),
      landing_(rows, cols) {}

void MotionEstimator::match(const RadianceState& state, const ExposedFrame& frame,
                            const ExposureTables& tables, const MatchContext& context,
                            const RatedFlows& rated, StateMotion& motion) {
  const ScratchLease room(pool_.scratch(), rows_, cols_, {{&frame_gray_, 1}, {&state_gray_, 1}});
  gray_of_frame(frame, frame_gray_, pool_);
  FlowRequest request{&frame_gray_, &state_gray_, &motion.to_previous.vectors, &motion.from_previous.vectors};
  gray_of_state(state.radiance, nullptr, tables, state_gray_, pool_);
  if (!last_.empty()) {
    shake_prediction(context.before_ratio);
    start_at_prediction(context.before_ratio, request);
    const ScratchLease blurred(pool_.scratch(), rows_, cols_, {{&blur_, 3}});
    // the instants lie evenly about the exposure's middle, so that the sign of the motion does not matter
    const float fraction = context.before_ratio * frame.blur_fraction;
    const bool blurs = context.blurs && exposure_blurs(predicted_, fraction, pool_);
    if (blurs) {
      blur_difference(state.radiance, predicted_, fraction, blur_, pool_);
      gray_of_state(state.radiance, &blur_, tables, state_gray_, pool_);
    }
  }
  flow_->compute(context.flow, request);
  if (rated.to_previous) rate_flow(motion.to_previous, motion.from_previous, nullptr, pool_);
  if (rated.from_previous) rate_flow(motion.from_previous, motion.to_previous, nullptr, pool_);
}

void MotionEstimator::complete(const RadianceState& state, const ExposedFrame& frame,
                               const MotionContext& context, FlowQuality quality, const RatedFlows& rated,
                               StateMotion& motion) {
  const ScratchLease room(pool_.scratch(), rows_, cols_, {{&clipped_, 1}, {&mask_, 1}});
  clipped_share(frame, clipped_);
  continue_predicted(context.before_ratio, motion.to_previous.vectors);
  if (context.after != nullptr && is_worth_bridging([](std::size_t) { return 0.f; })) {
    const ScratchLease more(pool_.scratch(), rows_, cols_, {{&clipped_after_, 1}});
    clipped_share(*context.after, clipped_after_);
    if (is_worth_bridging([&](std::size_t i) { return clipped_after_.samples()[i]; })) {
      const ScratchLease flows(pool_.scratch(), rows_, cols_, {{&after_to_state_, 2}, {&state_to_after_, 2}});
      match_after(state, context, quality);
      bridge(context, motion);
    }
  }
  rate_flow(motion.to_previous, motion.from_previous, &frame, pool_);
  if (rated.from_previous) rate_flow(motion.from_previous, motion.to_previous, nullptr, pool_);
  predict(context.before_ratio, motion.to_previous.vectors);
  copy_in_parallel(motion.to_previous.vectors, last_, pool_);
}

// Whether enough of the picture is clipped in the frame and not in the one after it, whose clipped share at a
// pixel is `after(i)`.
template <class After>
bool MotionEstimator::is_worth_bridging(After&& after) const {
  constexpr double kWorthwhile = 0.02;  // share of the picture
  const double enough = kWorthwhile * static_cast<double>(clipped_.size());
  double useful = 0;
  for (std::size_t i = 0; i < clipped_.size() && useful <= enough; ++i)
    useful += static_cast<double>(clipped_.samples()[i] * (1 - after(i)));
  return useful > enough;
}

// By what the grays tell of the camera.
void MotionEstimator::shake_prediction(float ratio) {
  const Offset shake = shake_.measure(frame_gray_, state_gray_, predicted_, ratio, pool_);
  if (shake.x == 0 && shake.y == 0) return;
  const float u = shake.x / ratio, v = shake.y / ratio;
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) predicted_.row(0, y)[x] += u, predicted_.row(1, y)[x] += v;
  });
}

// Where a search between a frame and the state starts: the motion that was predicted, for `ratio` of the last
// step's time.
void MotionEstimator::start_at_prediction(float ratio, FlowRequest& request) const {
  if (last_.empty()) return;
  request.start_a_to_b = {&predicted_, ratio, true};
  request.start_b_to_a = {&predicted_, -ratio};
}

// Where the frame is clipped, its motion is the one that was predicted.
void MotionEstimator::continue_predicted(float ratio, Image<float>& to) {
  const auto longest = static_cast<float>(rows_ + cols_);  // it leads out of the picture from anywhere
  std::swap(measured_, measured_before_);
  measured_.reshape(1, rows_, cols_);
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      clipped_motion_kernels().go_on({.at = {rows_, cols_, y},
                                      .clipped = clipped_.row(0, y),
                                      .predicted = last_.empty() ? nullptr : predicted_.plane(0),
                                      .measured = last_.empty() ? nullptr : measured_before_.plane(0),
                                      .ratio = ratio,
                                      .u = to.row(0, y),
                                      .v = to.row(1, y),
                                      .measured_now = measured_.row(0, y)});
      for (int c = 0; c < 2; ++c) limit(to.row(c, y), cols_, longest);
    }
  });
}

// The flow between the state and the frame after the one that is completed.
void MotionEstimator::match_after(const RadianceState& state, const MotionContext& context,
                                  FlowQuality quality) {
  const ScratchLease grays(pool_.scratch(), rows_, cols_, {{&frame_gray_, 1}, {&state_gray_, 1}});
  gray_of_frame(*context.after, frame_gray_, pool_);
  gray_of_state(state.radiance, nullptr, *context.after_tables, state_gray_, pool_);
  FlowRequest request{&frame_gray_, &state_gray_, &after_to_state_, &state_to_after_};
  start_at_prediction(context.before_ratio / context.after_ratio, request);
  flow_->compute(quality, request);
}

// Motion at clipped pixels of a frame, from the flow between the state before it and the frame after it, and
// from the motion before.
void MotionEstimator::bridge(const MotionContext& context, StateMotion& motion) {
  Image<float>&to = motion.to_previous.vectors, &from = motion.from_previous.vectors;
  const float r = context.after_ratio;
  const bool changes = !last_.empty() && tells_change(context.before_ratio);
  const PathAhead path{.after_to_state = after_to_state_.plane(0),
                       .state_to_after = state_to_after_.plane(0),
                       .last = changes ? last_.plane(0) : nullptr,
                       .measured = changes ? measured_before_.plane(0) : nullptr,
                       .share = r,
                       .before = r / context.before_ratio};
  bridge_error_.compare(path, clipped_, clipped_after_, to, pool_);
  const Image<float>& off = bridge_error_.cells();
  landing_.throw_ahead(state_to_after_, after_to_state_, kFastOverClipped, r);
  const Image<float>& landed = landing_.cells();
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      clipped_motion_kernels().bridge({.at = {rows_, cols_, y},
                                       .clipped = clipped_.row(0, y),
                                       .clipped_after = clipped_after_.plane(0),
                                       .path = path,
                                       .landed_u = landed.row(0, y / kLandingCell),
                                       .landed_v = landed.row(1, y / kLandingCell),
                                       .from = from.plane(0),
                                       .u = to.row(0, y),
                                       .v = to.row(1, y),
                                       .measured = measured_.row(0, y),
                                       .off_u = off.row(0, y / kLandingCell),
                                       .off_v = off.row(1, y / kLandingCell)});
  });
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      clipped_motion_kernels().bridge_ahead({.at = {rows_, cols_, y},
                                             .clipped = clipped_.plane(0),
                                             .clipped_after = clipped_after_.plane(0),
                                             .path = path,
                                             .to = to.plane(0),
                                             .u = from.row(0, y),
                                             .v = from.row(1, y),
                                             .off = off.plane(0)});
  });
}

// ratio: of this motion's time to the last one's.
void MotionEstimator::predict(float ratio, const Image<float>& motion) {
  if (last_.empty() || !tells_change(ratio)) return copy_in_parallel(motion, predicted_, pool_);
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      clipped_motion_kernels().predict({.at = {rows_, cols_, y},
                                        .u = motion.row(0, y),
                                        .v = motion.row(1, y),
                                        .measured = measured_.row(0, y),
                                        .last = last_.plane(0),
                                        .measured_before = measured_before_.plane(0),
                                        .ratio = ratio,
                                        .next_u = predicted_.row(0, y),
                                        .next_v = predicted_.row(1, y)});
  });
}

// Share of the 5x5 pixels around each pixel that are clipped, bright or dark, in all channels.
void MotionEstimator::clipped_share(const ExposedFrame& frame, Image<float>& share) {
  const clip_policy::UsableCodes usable = clip_policy::kMotionShare;
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) mark_clipped(frame.codes, y, usable, mask_.row(0, y));
  });
  box_mean(mask_, 2, share, pool_);
}

std::unique_ptr<MotionPrior> make_motion_prior(int rows, int cols, WorkerPool& pool, GpuDevice* gpu) {
  return std::make_unique<MotionEstimator>(rows, cols, pool, gpu);
}

}  // namespace hdrcam
