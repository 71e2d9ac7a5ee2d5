#include "firmware_host/run/rung_times.h"

#include <algorithm>
#include <span>

#include "hal/core/check.h"
#include "hal/core/median.h"
#include "hal/core/quantile.h"

namespace hdrcam {
namespace {

constexpr double kUpperQuartile = 0.75;
constexpr int kSettling = 1;  // frame times
constexpr double kLeastSteady_ms = 1e-3;

}  // namespace

std::optional<FrameTime> RungTimes::add(const FrameWork& work, int of) {
  pending_.total_ms += work.total_ms;
  pending_.steady_ms += work.steady_ms;
  if (++pending_frames_ < of) return std::nullopt;
  const FrameTime mean{pending_.total_ms / pending_frames_,
                       std::max(pending_.steady_ms / pending_frames_, kLeastSteady_ms)};
  pending_ = {};
  pending_frames_ = 0;
  if (unsettled_ > 0)
    --unsettled_;
  else
    window_[count_++ % kWindow] = mean;
  return mean;
}

void RungTimes::restart() {
  count_ = 0;
  unsettled_ = kSettling;
  pending_ = {};
  pending_frames_ = 0;
}

std::size_t RungTimes::kept() const { return std::min(count_, kWindow); }

FrameTime RungTimes::upper_quartile(std::size_t newest) const {
  std::array<FrameTime, kWindow> sorted{};
  newest = std::min(newest, kept());
  for (std::size_t i = 0; i < newest; ++i) sorted[i] = window_[(count_ - 1 - i) % kWindow];
  return quantile(std::span(sorted).first(newest), kUpperQuartile,
                  [](const FrameTime& a, const FrameTime& b) { return a.total_ms < b.total_ms; });
}

FrameTime RungTimes::mean() const {
  HDRCAM_CHECK(kept() > 1);
  FrameTime sum, longest, second;
  for (std::size_t i = 0; i < kept(); ++i) {
    const FrameTime& time = window_[i];
    sum.total_ms += time.total_ms;
    sum.steady_ms += time.steady_ms;
    const bool longer = time.total_ms > longest.total_ms;
    if (longer || time.total_ms > second.total_ms) second = longer ? longest : time;
    if (longer) longest = time;
  }
  const auto n = static_cast<double>(kept());
  return {(sum.total_ms - longest.total_ms + second.total_ms) / n,
          (sum.steady_ms - longest.steady_ms + second.steady_ms) / n};
}

FrameTime RungTimes::usual() const { return frames_queue_ ? mean() : upper_quartile(kWindow); }

double RungTimes::steady_ms() const {
  if (frames_queue_) return mean().steady_ms;
  std::array<double, kWindow> sorted{};
  for (std::size_t i = 0; i < kept(); ++i) sorted[i] = window_[i].steady_ms;
  return median(std::span(sorted).first(kept()));
}

double RungTimes::ratio() const {
  if (frames_queue_) return mean().ratio();
  std::array<double, kWindow> sorted{};
  for (std::size_t i = 0; i < kept(); ++i) sorted[i] = window_[i].ratio();
  return quantile(std::span(sorted).first(kept()), kUpperQuartile);
}

}  // namespace hdrcam
