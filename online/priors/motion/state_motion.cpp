#include "online/priors/motion/state_motion.h"

#include <cmath>

#include "capture/clip_policy.h"
#include "hal/core/interpolate.h"
#include "online/pictures/for_samples.h"
#include "online/pictures/local_statistics.h"
#include "online/pictures/warp.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/state/exposure_blur.h"

namespace hdrcam {
namespace {

constexpr float kRed = 0.299f, kGreen = 0.587f, kBlue = 0.114f;

float to_gray(float r, float g, float b) { return kRed * r + kGreen * g + kBlue * b; }

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

// the state as the camera would have recorded it at this exposure
void gray_of_state(const Image<float>& radiance, const ExposureTables& tables, Image<float>& gray,
                   WorkerPool& pool) {
  gray.reshape(1, radiance.rows(), radiance.cols());
  pool.for_rows(radiance.rows(), [&](int y0, int y1) {
    constexpr int kBlock = 64;
    std::array<std::array<float, kBlock>, 3> codes;
    for (int y = y0; y < y1; ++y)
      for (int x0 = 0; x0 < radiance.cols(); x0 += kBlock) {
        const int n = std::min(kBlock, radiance.cols() - x0);
        for (int c = 0; c < 3; ++c)
          tables.codes(c, {radiance.row(c, y) + x0, static_cast<std::size_t>(n)},
                       codes[static_cast<std::size_t>(c)].data());
        const auto& [r, g, b] = codes;
        float* out = gray.row(0, y) + x0;
        for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) out[i] = to_gray(r[i], g[i], b[i]);
      }
  });
}

// 1 where all channels of a row are clipped, bright or dark, 0 elsewhere.
void mark_clipped(const Image<float>& codes, int y, const clip_policy::UsableCodes& usable, float* clipped) {
  const float *r = codes.row(0, y), *g = codes.row(1, y), *b = codes.row(2, y);
  for (int x = 0; x < codes.cols(); ++x) {
    const float least = std::min(std::min(r[x], g[x]), b[x]), most = std::max(std::max(r[x], g[x]), b[x]);
    const float dark = most <= usable.darkest ? 1.f : 0.f;
    clipped[x] = least >= usable.brightest ? 1.f : dark;
  }
}

// Forward-backward agreement: exp(-|there and back|^2 / 2); 0 where the flow leaves the picture.
void rate_flow(FlowField& flow, const FlowField& back, Image<float>& warped, WorkerPool& pool) {
  const int rows = flow.vectors.rows(), cols = flow.vectors.cols();
  warp_linear(back.vectors, flow.vectors, warped, pool);
  flow.confidence.reshape(1, rows, cols);
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      flow_kernels().agree(flow.vectors.row(0, y), flow.vectors.row(1, y), warped.row(0, y), warped.row(1, y),
                           cols, flow.confidence.row(0, y));
  });
}

void forget_outside(FlowField& flow, WorkerPool& pool) {
  const int rows = flow.vectors.rows(), cols = flow.vectors.cols();
  pool.for_rows(rows, [&](int y0, int y1) {
    const float right = static_cast<float>(cols) - 0.5f, bottom = static_cast<float>(rows) - 0.5f;
    for (int y = y0; y < y1; ++y) {
      const float *u = flow.vectors.row(0, y), *v = flow.vectors.row(1, y);
      float* confidence = flow.confidence.row(0, y);
      for (int x = 0; x < cols; ++x) {  // without branches, so that it becomes vectors
        const float px = static_cast<float>(x) + u[x], py = static_cast<float>(y) + v[x];
        float kept = px >= -0.5f ? confidence[x] : 0;
        kept = px <= right ? kept : 0, kept = py >= -0.5f ? kept : 0, kept = py <= bottom ? kept : 0;
        confidence[x] = kept;
      }
    }
  });
}

}  // namespace

MotionEstimator::MotionEstimator(int rows, int cols, WorkerPool& pool)
    : rows_(rows), cols_(cols), pool_(pool), flow_(pool) {}

void MotionEstimator::match(const RadianceState& state, const ExposedFrame& frame,
                            const ExposureTables& tables, FlowQuality quality, StateMotion& motion) {
  const Borrowed room(pool_.scratch(), rows_, cols_, {{&frame_gray_, 1}, {&state_gray_, 1}});
  gray_of_frame(frame, frame_gray_, pool_);
  if (last_.empty()) {
    gray_of_state(state.radiance, tables, state_gray_, pool_);
    flow_.compute(quality,
                  {&frame_gray_, &state_gray_, &motion.to_previous.vectors, &motion.from_previous.vectors});
  } else {
    const Borrowed more(pool_.scratch(), rows_, cols_, {{&start_from_, 2}, {&start_to_, 2}});
    const double interval_s = to_seconds(frame.facts.timestamp - last_time_);
    start_at_last(last_interval_s_ > 0 && interval_s > 0
                      ? static_cast<float>(std::clamp(interval_s / last_interval_s_, 0.1, 10.0))
                      : 1.f,
                  start_to_, start_from_);
    {
      const Borrowed blurred(pool_.scratch(), rows_, cols_, {{&blur_, 3}});
      blur_difference(state.radiance, start_from_, frame.blur_fraction, blur_, pool_);
      for_samples(blur_.size(), pool_, [&](std::size_t i0, std::size_t i1) {
        const float* sharp = state.radiance.plane(0);
        float* seen = blur_.plane(0);
        for (std::size_t i = i0; i < i1; ++i) seen[i] += sharp[i];
      });
      gray_of_state(blur_, tables, state_gray_, pool_);
    }
    flow_.compute(quality, {&frame_gray_, &state_gray_, &motion.to_previous.vectors,
                            &motion.from_previous.vectors, &start_to_, &start_from_});
  }
  rate(nullptr, motion);
}

void MotionEstimator::complete(const RadianceState& state, const ExposedFrame& frame,
                               const MotionContext& context, FlowQuality quality, StateMotion& motion) {
  const Borrowed room(pool_.scratch(), rows_, cols_, {{&clipped_, 1}, {&mask_, 1}});
  clipped_share(frame, clipped_);
  continue_last(context.before_ratio, motion.to_previous.vectors);
  if (context.after != nullptr) {
    const Borrowed more(pool_.scratch(), rows_, cols_, {{&clipped_after_, 1}});
    clipped_share(*context.after, clipped_after_);
    double useful = 0;
    for (std::size_t i = 0; i < clipped_.size(); ++i)
      useful += static_cast<double>(clipped_.samples()[i] * (1 - clipped_after_.samples()[i]));
    constexpr double kWorthwhile = 0.005;  // share of the picture
    if (useful > kWorthwhile * static_cast<double>(clipped_.size())) {
      const Borrowed flows(pool_.scratch(), rows_, cols_, {{&after_to_state_, 2}, {&state_to_after_, 2}});
      match_after(state, context, quality);
      bridge(context.after_ratio, motion);
    }
  }
  rate(&frame, motion);
  if (!last_.empty()) last_interval_s_ = to_seconds(frame.facts.timestamp - last_time_);
  last_time_ = frame.facts.timestamp;
  copy(motion.to_previous.vectors, last_, pool_);
}

// Where a search starts: the last motion goes on at constant velocity, for `ratio` of its own time. At the
// state's pixels, and at those of the picture that the state is matched with.
void MotionEstimator::start_at_last(float ratio, Image<float>& to, Image<float>& from) {
  const Borrowed room(pool_.scratch(), rows_, cols_, {{&warped_, 2}});
  scale(last_, ratio, warped_, pool_);
  warp_linear(warped_, warped_, to, pool_);
  scale(warped_, -1, from, pool_);
}

// Where the frame is clipped, its motion is that of the last step. What is clipped in one frame after the
// other has nobody who measures it, and a motion that was wrong once would stay; so it gives way, more with
// each such frame, to what the search spreads over it from its surroundings.
void MotionEstimator::continue_last(float ratio, Image<float>& to) {
  constexpr float kKept = 0.9f;  // of what was measured, for each frame that continues it
  const Borrowed room(pool_.scratch(), rows_, cols_, {{&warped_, 2}, {&still_measured_, 1}});
  if (last_.empty()) {
    measured_.reshape(1, rows_, cols_);
    warped_.fill(0), still_measured_.fill(0);
  } else {
    warp_linear(last_, to, warped_, pool_);
    warp_linear(measured_, to, still_measured_, pool_);
  }
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) {
        const float clipped = smooth_step(0.5f, 0.95f, clipped_.at(0, y, x));
        const float still = still_measured_.at(0, y, x), a = clipped * smooth_step(0, 1, still);
        measured_.at(0, y, x) = 1 - a * (1 - kKept * still);
        for (int d = 0; d < 2; ++d) to.at(d, y, x) += a * (ratio * warped_.at(d, y, x) - to.at(d, y, x));
      }
  });
}

// The flow between the state and the frame after the one that is completed. The guesses lie where the answers
// go: the search has read them before it writes.
void MotionEstimator::match_after(const RadianceState& state, const MotionContext& context,
                                  FlowQuality quality) {
  const Borrowed grays(pool_.scratch(), rows_, cols_, {{&frame_gray_, 1}, {&state_gray_, 1}});
  gray_of_frame(*context.after, frame_gray_, pool_);
  gray_of_state(state.radiance, *context.after_tables, state_gray_, pool_);
  FlowRequest request{&frame_gray_, &state_gray_, &after_to_state_, &state_to_after_};
  if (!last_.empty()) {
    start_at_last(context.before_ratio / context.after_ratio, after_to_state_, state_to_after_);
    request.start_a_to_b = &after_to_state_, request.start_b_to_a = &state_to_after_;
  }
  flow_.compute(quality, request);
}

// Motion at clipped pixels of a frame, from the flow between the state before it and the frame after it, at
// constant velocity. A pixel x of the frame in between, with motion u to the state, is at x + u in the state
// and at x - u (1 - r) / r in the frame after, where r is its share of the time between them; both flows are
// read there (a fixed point, three iterations) and averaged.
void MotionEstimator::bridge(float r, StateMotion& motion) {
  constexpr int kRounds = 3;
  const auto half_difference = [&](const Image<float>& a, const Image<float>& b) {
    for_samples(bridged_.size(), pool_, [&](std::size_t i0, std::size_t i1) {
      const float *from_after = a.plane(0), *from_state = b.plane(0);
      float* bridged = bridged_.plane(0);
      for (std::size_t i = i0; i < i1; ++i) bridged[i] = 0.5f * r * (from_after[i] - from_state[i]);
    });
  };
  Image<float>&to = motion.to_previous.vectors, &from = motion.from_previous.vectors;
  const Borrowed room(
      pool_.scratch(), rows_, cols_,
      {{&bridged_, 2}, {&ahead_, 2}, {&seen_from_after_, 2}, {&seen_from_state_, 2}, {&clipped_seen_, 1}});
  const float onward = -(1 - r) / r;
  half_difference(after_to_state_, state_to_after_);
  for (int round = 1; round < kRounds; ++round) {
    scale(bridged_, onward, ahead_, pool_);
    warp_linear(after_to_state_, ahead_, seen_from_after_, pool_);
    warp_linear(state_to_after_, bridged_, seen_from_state_, pool_);
    half_difference(seen_from_after_, seen_from_state_);
  }
  // to the state, at the pixels of the frame
  scale(bridged_, onward, ahead_, pool_);
  warp_linear(clipped_after_, ahead_, mask_, pool_);
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) {
        const float a =
            smooth_step(0.4f, 0.9f, clipped_.at(0, y, x)) * (1 - smooth_step(0.1f, 0.6f, mask_.at(0, y, x)));
        for (int d = 0; d < 2; ++d) to.at(d, y, x) += a * (bridged_.at(d, y, x) - to.at(d, y, x));
        measured_.at(0, y, x) += a * (1 - measured_.at(0, y, x));
      }
  });
  // from the state, at its own pixels
  scale(state_to_after_, r, ahead_, pool_);
  warp_linear(clipped_, ahead_, mask_, pool_);
  warp_linear(clipped_after_, state_to_after_, clipped_seen_, pool_);
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) {
        const float a = smooth_step(0.4f, 0.9f, mask_.at(0, y, x)) *
                        (1 - smooth_step(0.1f, 0.6f, clipped_seen_.at(0, y, x)));
        for (int d = 0; d < 2; ++d) from.at(d, y, x) += a * (ahead_.at(d, y, x) - from.at(d, y, x));
      }
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

void MotionEstimator::rate(const ExposedFrame* frame, StateMotion& motion) {
  const clip_policy::UsableCodes usable = clip_policy::kMotionRating;
  constexpr float kClippedConfidence = 0.5f;  // assumed where agreement cannot be measured
  const Borrowed room(pool_.scratch(), rows_, cols_, {{&warped_, 2}});
  rate_flow(motion.to_previous, motion.from_previous, warped_, pool_);
  rate_flow(motion.from_previous, motion.to_previous, warped_, pool_);
  if (frame != nullptr)
    pool_.for_rows(rows_, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        float *clipped = warped_.row(0, y), *confidence = motion.to_previous.confidence.row(0, y);
        mark_clipped(frame->codes, y, usable, clipped);
        for (int x = 0; x < cols_; ++x) {
          const float known = confidence[x], assumed = std::max(kClippedConfidence, known);
          confidence[x] = clipped[x] > 0 ? assumed : known;
        }
      }
    });
  forget_outside(motion.to_previous, pool_);
  forget_outside(motion.from_previous, pool_);
}

std::unique_ptr<MotionPrior> make_motion_prior(int rows, int cols, WorkerPool& pool) {
  return std::make_unique<MotionEstimator>(rows, cols, pool);
}

}  // namespace hdrcam
