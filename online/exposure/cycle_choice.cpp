#include "online/exposure/cycle_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "hal/core/counted.h"

namespace hdrcam {
namespace {

constexpr double kStop = std::numbers::ln2;
constexpr double kRounding = 1.001;  // of a factor: half stops up and down again do not end where they began

}  // namespace

std::string describe(const CycleRequest& request) {
  return fmt::format("{}: expected error {:+.0f} %; motion blur was {:.0f} % of it before",
                     describe(request.cycle), 100 * (request.error_after / request.error_before - 1),
                     100 * request.blur_share);
}

CycleChoice::CycleChoice(const ExposureLimits& limits, const StateOptions& state)
    : limits_(limits),
      gaps_(limits.cycle.size()),
      order_(limits.cycle.size()),
      cycle_(limits.cycle),
      changed_(limits.cycle.size()),
      tried_(limits.cycle.size()),
      pixels_(state.fusion),
      forecast_(state) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  const auto log_of = [&](std::size_t slot) { return log_product(limits_.cycle[slot]); };
  std::ranges::stable_sort(order_, [&](auto a, auto b) { return log_of(a) < log_of(b); });
  for (std::size_t k = 1; k < order_.size(); ++k) gaps_[k] = log_of(order_[k]) - log_of(order_[k - 1]);
}

std::string CycleChoice::summary() const {
  if (requests_ == 0) return "the fit asked for no other exposures";
  return fmt::format("the fit asked for other exposures {}; last for {}", counted(requests_, "time"), last_);
}

std::optional<CycleRequest> CycleChoice::observe(const FrameEstimate& estimate,
                                                 const ExposureForecast::Sensor& sensor) {
  if (first_white_ == 0) {
    double least = limits_.cycle.front().product();
    for (const Exposure& exposure : limits_.cycle) least = std::min(least, exposure.product());
    first_white_ = static_cast<float>(estimate.reference_exposure / least);
  }
  if (waiting_ > 0) --waiting_;
  switch (search_) {
    case Search::Waits:
      pixels_.see(estimate);
      if (waiting_ == 0 && pixels_.complete()) begin(estimate, sensor);
      return std::nullopt;
    case Search::Coarse:
      if (!improve(1)) search_ = Search::Fine;
      return std::nullopt;
    case Search::Fine:
      if (!improve(0.5)) search_ = Search::Ends;
      return std::nullopt;
    case Search::Ends:
      break;
  }
  return conclude();
}

void CycleChoice::begin(const FrameEstimate& estimate, const ExposureForecast::Sensor& sensor) {
  forecast_.look(pixels_, sensor, estimate.reference_exposure, first_white_);
  better_ = cycle_;
  error_ = forecast_.error(better_, ExposureForecast::Blur::Counted);
  for (std::size_t s = 0; s < better_.size(); ++s)
    forecast_.sample_variances(better_[s], ExposureForecast::Blur::Counted, variances_[s]);
  search_ = Search::Coarse;
}

// One round: the best change by so many stops of time, of gain, or of one for the other. It is that of one
// slot, or of it and all that are exposed longer: of slots that are as near as they may be none moves alone.
bool CycleChoice::improve(double stops) {
  constexpr double kWorthIt = 0.997;  // of the error so far
  constexpr struct { int time, gain; } kChanges[] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, 1}, {1, -1}};
  const std::size_t slots = order_.size();
  std::array<const ExposureForecast::Values*, ExposureSchedule::kMaxSlots> changed_or_not{}, variances{};
  double least = kWorthIt * error_;
  std::vector<Exposure> best;
  const auto try_slots = [&](std::size_t first, std::size_t last) {  // in order of exposure
    for (std::size_t s = 0; s < slots; ++s) tried_[s] = better_[s], variances[s] = &variances_[s];
    for (std::size_t k = first; k <= last; ++k) {
      const std::size_t s = order_[k];
      tried_[s] = changed_[s], variances[s] = changed_or_not[s];
    }
    if (tried_ == better_ || !keeps_order(tried_)) return;
    const double error = forecast_.error({variances.data(), slots});
    if (error < least) least = error, best = tried_;
  };
  for (const auto& change : kChanges) {
    for (std::size_t s = 0; s < slots; ++s) {
      const auto exposure = fitted(s, to_seconds(better_[s].time) * std::exp2(change.time * stops),
                                   better_[s].gain * std::exp2(change.gain * stops));
      changed_[s] = exposure.value_or(better_[s]);
      changed_or_not[s] = exposure ? &changed_variances_[s] : &variances_[s];
      if (exposure)
        forecast_.sample_variances(*exposure, ExposureForecast::Blur::Counted, changed_variances_[s]);
    }
    for (std::size_t first = 0; first < slots; ++first) {
      try_slots(first, first);
      if (first + 1 < slots) try_slots(first, slots - 1);
    }
  }
  if (best.empty()) return false;
  for (std::size_t s = 0; s < slots; ++s)
    if (best[s] != better_[s])
      forecast_.sample_variances(best[s], ExposureForecast::Blur::Counted, variances_[s]);
  better_ = best, error_ = least;
  return true;
}

// The exposure that the camera can do; none where it would be the one there is, or would begin to flicker.
std::optional<Exposure> CycleChoice::fitted(std::size_t slot, double time_s, double gain) const {
  const auto fitting_time = fitted_time(slot, from_seconds(time_s));
  if (!fitting_time) return std::nullopt;
  if (gain < limits_.least_gain / kRounding || gain > limits_.greatest_gain * kRounding) return std::nullopt;
  Exposure exposure{*fitting_time, std::clamp(gain, limits_.least_gain, limits_.greatest_gain)};
  if (exposure.gain < limits_.least_gain * kRounding) exposure.gain = limits_.least_gain;
  if (exposure == better_[slot]) return std::nullopt;
  return exposure;
}

// Under lamps whole half periods of the mains stay such, and less than one stays less. What is at most half a
// stop too long is as long as it may be.
std::optional<Duration> CycleChoice::fitted_time(std::size_t slot, Duration time) const {
  constexpr double kHalfStop = std::numbers::sqrt2;
  if (const Duration half = half_period(limits_.mains); half > Duration(0)) {
    if (lasts(limits_.cycle[slot].time, half))
      time = whole_half_periods(time, half, limits_.longest);
    else if (time >= half)
      return std::nullopt;
  }
  if (time > limits_.longest && to_seconds(time) < kHalfStop * kRounding * to_seconds(limits_.longest))
    time = limits_.longest;
  if (time < limits_.shortest || time > limits_.longest) return std::nullopt;
  return time;
}

bool CycleChoice::keeps_order(const std::vector<Exposure>& cycle) const {
  constexpr double kSlack = 0.01;  // of ln E
  const auto log_of = [&](std::size_t k) { return log_product(cycle[order_[k]]); };
  if (std::abs(log_of(0) - log_product(limits_.cycle[order_[0]])) > kSlack) return false;
  for (std::size_t k = 1; k < order_.size(); ++k) {
    // near enough to be matched with each other, and far enough apart for the proof of their labels
    const double gap = log_of(k) - log_of(k - 1);
    if (gap > gaps_[k] + kSlack || gap < std::min(kStop, gaps_[k]) - kSlack) return false;
  }
  return true;
}

std::optional<CycleRequest> CycleChoice::conclude() {
  search_ = Search::Waits;
  pixels_.forget();
  CycleRequest request{.cycle = better_, .error_after = error_};
  request.error_before = forecast_.error(cycle_, ExposureForecast::Blur::Counted);
  if (!(request.error_after < (1 - kLeastGain) * request.error_before)) return std::nullopt;
  request.blur_share = 1 - forecast_.error(cycle_, ExposureForecast::Blur::LeftOut) / request.error_before;
  return request;
}

void CycleChoice::runs(const CycleRequest& request) {
  cycle_ = request.cycle;
  waiting_ = kSettling;
  ++requests_, last_ = describe(request);
}

}  // namespace hdrcam
