#include "render/scores/scores.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "render/scores/estimates.h"
#include "render/scores/ground_truth.h"
#include "render/scores/motion_scores.h"
#include "render/scores/order_statistics.h"

namespace hdrcam {
namespace {

// Well exposed, as a fraction of white: neither noisy nor near clipping.
constexpr float kWellExposedFrom = 0.004f, kWellExposedTo = 0.6f;

constexpr std::size_t kWhiteStride = 7;  // every seventh pixel tells white
constexpr double kWhitePercent = 99.9;

double mean_or_zero(const RunningMean& of) { return of.mean().value_or(0); }

// The results of one frame that the next needs.
struct PreviousFrame {
  int frame = -1;
  ComparablePair pair;
  Image<std::uint8_t> moving;
  MotionTruth motion;  // to the next frame
};

// The motion of dynamic objects; empty where the truth does not mark them.
MotionTruth only_moving(const MotionTruth& motion, const Image<std::uint8_t>& moving) {
  MotionTruth some{motion.flow.clone(), motion.comparable.clone()};
  for (std::size_t i = 0; i < some.comparable.size(); ++i)
    if (moving.empty() || moving.samples()[i] == 0) some.comparable.samples()[i] = 0;
  return some;
}

class ClipScoring {
 public:
  // novel: views from other cameras, or null.
  ClipScoring(const GroundTruth& truth, const Estimates& estimates, std::optional<Estimates> novel,
              const ScoreOptions& options)
      : truth_(truth), estimates_(estimates), novel_(std::move(novel)), options_(options) {}

  Result<ClipScores> run() {
    TRY(choose_frames());
    TRY(find_white());
    TRY(find_gains());
    for (const int frame : frames_) TRY(score(frame));
    summarise();
    return std::move(scores_);
  }

 private:
  Result<void> choose_frames() {
    for (int i = options_.skip; i < truth_.frames() - options_.skip; ++i)
      if (const std::uint64_t number = truth_.number(i); estimates_.contains(number))
        frames_.push_back(i);
      else
        scores_.missing.push_back(number);
    const std::vector<std::uint64_t> estimated = estimates_.numbers();
    std::set<std::uint64_t> of_clip;
    for (int i = 0; i < truth_.frames(); ++i) of_clip.insert(truth_.number(i));
    std::ranges::copy_if(estimated, std::back_inserter(scores_.not_in_clip),
                         [&](std::uint64_t number) { return !of_clip.contains(number); });
    if (!frames_.empty()) return {};
    if (2 * options_.skip >= truth_.frames())
      return Error{ErrorCode::Invalid,
                   fmt::format("the clip has {} frames, and {} skipped at either end leave none; skip fewer",
                               truth_.frames(), options_.skip)};
    std::string numbers;
    if (!of_clip.empty())
      numbers = fmt::format(", of numbers {} to {},", *of_clip.begin(), *of_clip.rbegin());
    return Error{
        ErrorCode::NotFound,
        fmt::format(
            "none of the {} frames of the clip{} can be compared with {} skipped at either end; check "
            "that the estimates, {} to {}, are numbered as the frames of the clip are",
            truth_.frames(), numbers, options_.skip, estimated.front(), estimated.back())};
  }

  Result<void> unless_stopped() const {
    if (options_.stop != nullptr && options_.stop->load())
      return Error{ErrorCode::Interrupted, "stopped while scoring"};
    return {};
  }

  // A percentile of some pixels' brightest channel.
  Result<void> find_white() {
    std::vector<float> brightest;
    for (const int frame : frames_) {
      TRY(unless_stopped());
      const Image<float> g = TRY(truth_.radiance(frame));
      for (std::size_t i = 0; i < g.plane_size(); i += kWhiteStride)
        brightest.push_back(std::max({g.plane(0)[i], g.plane(1)[i], g.plane(2)[i]}));
    }
    scores_.shared.white = std::min(percentile(brightest, kWhitePercent), truth_.shortest_saturation());
    if (!(scores_.shared.white > 0))
      return Error{ErrorCode::Invalid,
                   "the ground truth of the clip is black; there is nothing to compare with"};
    return {};
  }

  // A gain is the median log ratio over some pixels, where they are well exposed; likewise the depth scale.
  Result<void> find_gains() {
    std::array<std::vector<float>, 3> log_ratios;
    std::vector<float> depth_ratios;
    for (const int frame : frames_) {
      TRY(unless_stopped());
      const Image<float> g = TRY(truth_.radiance(frame));
      const Estimate e = TRY(estimates_.read(truth_.number(frame), truth_.rows(), truth_.cols()));
      TRY(check_moment(frame, e));
      collect_log_ratios(g, e.radiance, log_ratios);
      if (e.depth.empty()) continue;
      const Image<float> depth = TRY(truth_.depth(frame));
      if (!depth.empty()) collect_depth_ratios(depth, e.depth, depth_ratios);
    }
    if (!depth_ratios.empty()) depth_scale_ = numpy_median(depth_ratios);
    return set_gains(log_ratios);
  }

  // A film counts its own frames, and may show another moment than the clip's frame of that number.
  Result<void> check_moment(int frame, const Estimate& e) const {
    if (!e.recorded_s || !(std::abs(*e.recorded_s - truth_.time_s(frame)) > truth_.interval_s() / 2))
      return {};
    return Error{
        ErrorCode::Invalid,
        fmt::format("'{}' is a film's frame that shows the recording at {:.3f} s, and frame {} of the "
                    "clip is at {:.3f} s; film the clip from its first frame, at its speed and frame "
                    "rate",
                    estimates_.path(truth_.number(frame)), *e.recorded_s, truth_.number(frame),
                    truth_.time_s(frame))};
  }

  void collect_log_ratios(const Image<float>& truth, const Image<float>& estimate,
                          std::array<std::vector<float>, 3>& log_ratios) const {
    const float from = kWellExposedFrom * static_cast<float>(scores_.shared.white);
    const float to = kWellExposedTo * static_cast<float>(scores_.shared.white);
    for (int c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < truth.plane_size(); i += kRatioStride)
        if (const float t = truth.plane(c)[i], v = estimate.plane(c)[i]; t > from && t < to && v > 0)
          log_ratios[static_cast<std::size_t>(c)].push_back(std::log(t / v));
  }

  // One for each channel; beside them their geometric mean, and how far each is from that.
  Result<void> set_gains(std::array<std::vector<float>, 3>& log_ratios) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (log_ratios[c].empty())
        return Error{ErrorCode::Invalid,
                     fmt::format("no pixel of channel {} is well exposed in both clip and estimates; do "
                                 "they show the same scene?",
                                 "RGB"[c])};
      scores_.shared.gain[c] = std::exp(numpy_median(log_ratios[c]));
    }
    const auto& gain = scores_.shared.gain;
    single_gain_ = scores_.shared;
    single_gain_.gain.fill(std::cbrt(gain[0] * gain[1] * gain[2]));
    for (std::size_t c = 0; c < 3; ++c) scores_.cast_stops[c] = std::log2(gain[c] / single_gain_.gain[c]);
    return {};
  }

  Result<void> score(int frame) {
    TRY(unless_stopped());
    const Image<float> g = TRY(truth_.radiance(frame));
    const Estimate e = TRY(estimates_.read(truth_.number(frame), truth_.rows(), truth_.cols()));
    note_not_finite(e, estimates_.path(truth_.number(frame)));
    PreviousFrame now{.frame = frame, .pair = {}, .moving = {}, .motion = {}};
    now.pair = comparable_pair(g, e.radiance, scores_.shared);
    now.moving = TRY(truth_.moving_mask(frame));
    now.motion = TRY(truth_.motion(frame));
    FrameScores& scored = scores_.frames.emplace_back();
    scored.frame = truth_.number(frame);
    scored.picture = score_picture(now.pair, now.moving);
    single_gain_db_.add(psnr_mu_db(g, e.radiance, single_gain_));
    // half-stop phases, ties to even
    phases_[static_cast<int>(std::nearbyint(std::log2(truth_.exposure(frame)) * 2))].add(
        scored.picture.log_bias_stops);
    if (previous_.frame == frame - 1 && !previous_.motion.flow.empty())
      scored.flicker_stops = score_since_previous(e, now);
    TRY(score_novel_view(frame));
    if (!e.flow_forward.empty() && !now.motion.flow.empty() && is_followed(frame))
      flow_forward_ += forward_flow_error(e.flow_forward, now.motion);
    if (!e.depth.empty()) {
      const Image<float> depth = TRY(truth_.depth(frame));
      if (!depth.empty()) depth_ += depth_error(depth, e.depth, depth_scale_);
    }
    previous_ = std::move(now);
    return {};
  }

  void note_not_finite(const Estimate& e, const std::string& path) {
    if (e.not_finite > 0) scores_.not_finite.push_back({path, e.not_finite});
  }

  // What happened since the frame before: its flicker, which is returned, and errors of flow back to it.
  std::optional<double> score_since_previous(const Estimate& e, const PreviousFrame& now) {
    const FlickerScores f =
        flicker({previous_.pair.truth_log2, previous_.pair.estimate_log2},
                {now.pair.truth_log2, now.pair.estimate_log2}, previous_.motion, previous_.moving);
    flicker_.add(f.all.mean()), flicker_background_.add(f.background.mean());
    if (!e.flow_backward.empty()) flow_backward_ += backward_flow_error(e.flow_backward, previous_.motion);
    if (!e.field_flow.empty()) {
      field_flow_ += backward_flow_error(e.field_flow, previous_.motion);
      field_flow_moving_ +=
          backward_flow_error(e.field_flow, only_moving(previous_.motion, previous_.moving));
    }
    return f.all.mean();
  }

  // Without the next frame a frame's motion leads to a later one, or is not known: files then have zeros.
  bool is_followed(int frame) const {
    return frame + 1 < truth_.frames() && estimates_.contains(truth_.number(frame + 1));
  }

  Result<void> score_novel_view(int frame) {
    if (!novel_ || !novel_->contains(truth_.number(frame))) return {};
    const Image<float> g = TRY(truth_.novel_radiance(frame));
    if (g.empty()) return {};
    const Estimate e = TRY(novel_->read(truth_.number(frame), truth_.rows(), truth_.cols()));
    note_not_finite(e, novel_->path(truth_.number(frame)));
    novel_psnr_mu_.add(
        score_picture(comparable_pair(g, e.radiance, scores_.shared), Image<std::uint8_t>{}).psnr_mu_db);
    return {};
  }

  void summarise() {
    RunningMean mu, linear, pu, ssim, log_rmse, log_bias, moving, phase, phase_square;
    for (const FrameScores& scored : scores_.frames) {
      const PictureScores& p = scored.picture;
      mu.add(p.psnr_mu_db), linear.add(p.psnr_l_db), pu.add(p.psnr_pu_db), ssim.add(p.ssim_mu);
      log_rmse.add(p.log_rmse_stops), log_bias.add(p.log_bias_stops), moving.add(p.psnr_mu_moving_db);
    }
    scores_.mean = {.psnr_mu_db = mean_or_zero(mu),
                    .psnr_l_db = mean_or_zero(linear),
                    .psnr_pu_db = mean_or_zero(pu),
                    .ssim_mu = mean_or_zero(ssim),
                    .log_rmse_stops = mean_or_zero(log_rmse),
                    .log_bias_stops = mean_or_zero(log_bias),
                    .psnr_mu_moving_db = moving.mean()};
    scores_.worst = *std::min_element(
        scores_.frames.begin(), scores_.frames.end(),
        [](const auto& a, const auto& b) { return a.picture.psnr_mu_db < b.picture.psnr_mu_db; });
    for (const auto& [half_stops, bias] : phases_) phase.add(mean_or_zero(bias));
    for (const auto& [half_stops, bias] : phases_) {
      const double apart = mean_or_zero(bias) - mean_or_zero(phase);
      phase_square.add(apart * apart);
    }
    scores_.phase_stops = std::sqrt(mean_or_zero(phase_square));
    scores_.flicker_stops = flicker_.mean(), scores_.flicker_background_stops = flicker_background_.mean();
    scores_.flow_backward_epe_px = flow_backward_.mean(), scores_.flow_forward_epe_px = flow_forward_.mean();
    scores_.field_flow_epe_px = field_flow_.mean();
    scores_.field_flow_moving_epe_px = field_flow_moving_.mean();
    scores_.novel_psnr_mu_db = novel_psnr_mu_.mean();
    scores_.depth_abs_rel = depth_.mean();
    scores_.psnr_mu_single_gain_db = mean_or_zero(single_gain_db_);
  }

  const GroundTruth& truth_;
  const Estimates& estimates_;
  const std::optional<Estimates> novel_;
  const ScoreOptions& options_;
  std::vector<int> frames_;  // to be compared
  double depth_scale_ = 1;
  Normalisation single_gain_;
  PreviousFrame previous_;
  std::map<int, RunningMean> phases_;  // mean log2 error by half-stops of exposure
  RunningMean flicker_, flicker_background_, single_gain_db_, novel_psnr_mu_;
  RunningMean depth_, flow_backward_, flow_forward_, field_flow_, field_flow_moving_;
  ClipScores scores_;
};

}  // namespace

Result<ClipScores> score_clip(Storage& storage, const std::string& clip_folder,
                              const std::string& estimates_folder, const ScoreOptions& options) {
  if (options.skip < 0)
    return Error{ErrorCode::Invalid, fmt::format("cannot skip {} frames; give 0 or more", options.skip)};
  const GroundTruth truth = TRY(GroundTruth::open(storage, clip_folder));
  const Estimates estimates = TRY(Estimates::open(storage, estimates_folder, options.is_scored));
  const auto novel = Estimates::open(storage, estimates_folder + "/novel", options.is_scored);
  if (!novel && novel.error().code != ErrorCode::NotFound) return novel.error();
  return ClipScoring(truth, estimates, novel ? std::optional(novel.value()) : std::nullopt, options).run();
}

}  // namespace hdrcam
