#include "capture/cycle_phase.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "capture/exposure_schedule.h"
#include "capture/order_check.h"
#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr double kLoss = 8;              // what an unannounced loss costs, squared deviations
constexpr double kSure = 4;              // by how much another phase must cost more, squared deviations
constexpr double kWorst = 16;            // what one step can cost at most: a cut, a lamp switched on
constexpr double kAcceptedResidual = 5;  // mean, of a walk that the pictures support
constexpr double kReference_s = 0.01;    // of an estimated cycle

// The expected error of a step: of any, and a part of its ratio, ln.
struct StepError {
  double least, share;
};
constexpr StepError kMeasuredError{0.25, 0.2}, kRoughError{0.3, 0.5};

// In expected errors, squared. No response stretches all ratios alike, so an error is a part of the ratio; of
// how bright a picture is as a whole, little more than the sign and the order is sure.
double cost_of(const CycleStep& step, double expected) {
  const StepError& error = step.kind == StepKind::Measured ? kMeasuredError : kRoughError;
  const double deviation = (step.log_ratio - expected) / (error.least + error.share * std::abs(expected));
  return std::min(deviation * deviation, kWorst);
}

// Mean ln exposure of a picture, black and clipped parts at the ends of what a code can say.
double brightness_of(const PhotometricSignature& picture) {
  constexpr float kDarkest = -5.5f, kClipped = 0;
  double sum = 0;
  for (int i = 0; i < picture.sites; ++i)
    sum += static_cast<double>(std::clamp(picture.by_rank[static_cast<std::size_t>(i)], kDarkest, kClipped));
  return picture.sites > 0 ? sum / picture.sites : 0;
}

struct Path {
  double cost = std::numeric_limits<double>::infinity();
  CycleWalk walk;
  std::vector<double> by_first_slot;  // what the walks from each slot cost at least
};

// The cheapest walk under one stretch.
Path cheapest(std::span<const CycleStep> steps, std::span<const double> log_exposures, double stretch) {
  const auto slots = static_cast<int>(log_exposures.size());
  const auto at = [&](int slot) { return log_exposures[static_cast<std::size_t>(slot)]; };
  std::vector<double> cost(log_exposures.size(), 0), next(log_exposures.size());
  std::vector<std::array<int, ExposureSchedule::kMaxSlots>> from(steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const int announced = (1 + steps[i].missing) % slots;  // the step that the times tell
    for (int to = 0; to < slots; ++to) {
      double best = std::numeric_limits<double>::infinity();
      for (int before = 0; before < slots; ++before) {
        double step = cost[static_cast<std::size_t>(before)];
        if ((before + announced) % slots != to) step += kLoss;
        step += cost_of(steps[i], stretch * (at(to) - at(before)));
        if (step < best) best = step, from[i][static_cast<std::size_t>(to)] = before;
      }
      next[static_cast<std::size_t>(to)] = best;
    }
    cost.swap(next);
  }
  Path path;
  const auto last = std::ranges::min_element(cost);
  path.cost = *last;
  path.by_first_slot.assign(log_exposures.size(), std::numeric_limits<double>::infinity());
  for (std::size_t to = 0; to < cost.size(); ++to) {
    std::size_t first = to;
    for (std::size_t i = steps.size(); i-- > 0;) first = static_cast<std::size_t>(from[i][first]);
    path.by_first_slot[first] = std::min(path.by_first_slot[first], cost[to]);
  }
  path.walk.stretch = stretch;
  path.walk.slots.resize(steps.size() + 1);
  path.walk.slots.back() = static_cast<int>(last - cost.begin());
  for (std::size_t i = steps.size(); i-- > 0;)
    path.walk.slots[i] = from[i][static_cast<std::size_t>(path.walk.slots[i + 1])];
  return path;
}

// Fills in how many frames are missing along the walk, and how many of its steps were measured.
void count_losses(std::span<const CycleStep> steps, int slots, CycleWalk& walk) {
  walk.lost_before.assign(walk.slots.size(), 0);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const int advance = ((walk.slots[i + 1] - walk.slots[i]) % slots + slots) % slots;
    const int fewest = (advance - 1 + slots) % slots;
    const int beyond = std::max(0, steps[i].missing - fewest);  // that the times tell, which jitter
    const int rounds = (beyond + (slots - 1) / 2) / slots;      // the nearest number, in doubt the lower one
    walk.lost_before[i + 1] = fewest + rounds * slots;
    if (steps[i].kind == StepKind::Measured) ++walk.measured;
  }
}

// Under the stretch that fits best.
Path best_path(std::span<const CycleStep> steps, std::span<const double> log_exposures) {
  constexpr double kLeast = 0.25, kMost = 2.5, kStep = 1.07;  // of the stretch: real cameras lie within
  Path best;
  std::vector<double> by_first_slot(log_exposures.size(), std::numeric_limits<double>::infinity());
  double stretch = kLeast;
  while (stretch <= kMost) {
    Path path = cheapest(steps, log_exposures, stretch);
    std::ranges::transform(by_first_slot, path.by_first_slot, by_first_slot.begin(),
                           [](double a, double b) { return std::min(a, b); });
    if (path.cost < best.cost) best = std::move(path);
    stretch *= kStep;
  }
  best.by_first_slot = std::move(by_first_slot);
  best.walk.ambiguous =
      std::ranges::count_if(best.by_first_slot, [&](double cost) { return cost < best.cost + kSure; }) > 1;
  return best;
}

// Pictures that do not alternate are explained as well by no cycle at all.
bool explains(const Path& path, std::span<const CycleStep> steps) {
  constexpr double kMostOfNone = 0.5;  // of what no cycle costs
  double without = 0;
  for (const CycleStep& step : steps) without += cost_of(step, 0);
  return path.cost < kMostOfNone * without;
}

// What is known of a step is stretched, so its sign alone counts.
bool is_out_of_order(const CycleWalk& walk, std::span<const CycleStep> steps,
                     std::span<const double> log_exposures) {
  constexpr int kLeast = 2;
  const auto at = [&](std::size_t frame) {
    return log_exposures[static_cast<std::size_t>(walk.slots[frame])];
  };
  OrderCheck order(kLeast);
  for (std::size_t i = 0; i < steps.size(); ++i) order.add(at(i), at(i + 1), steps[i]);
  return order.objects();
}

// ln exposures around their mean, from the step of each slot to the next; what is left after a round is
// spread.
std::vector<double> around_mean(std::span<const double> to_next) {
  const auto n = static_cast<double>(to_next.size());
  const double left = std::accumulate(to_next.begin(), to_next.end(), 0.0) / n;
  std::vector<double> log_exposures{0};
  for (std::size_t i = 0; i + 1 < to_next.size(); ++i)
    log_exposures.push_back(log_exposures.back() + to_next[i] - left);
  const double mean = std::accumulate(log_exposures.begin(), log_exposures.end(), 0.0) / n;
  for (double& value : log_exposures) value -= mean;
  return log_exposures;
}

// The steps from each slot to the next, by the ratios that were seen of each.
std::vector<double> medians(std::vector<std::vector<double>>& ratios) {
  std::vector<double> to_next;
  to_next.reserve(ratios.size());
  for (auto& of_slot : ratios) to_next.push_back(median(of_slot));
  return to_next;
}

// From the stretch of the clip that repeats best: a loss shifts the slots after it.
std::vector<double> first_guess(std::span<const CycleStep> steps, std::size_t period) {
  const std::size_t window = std::min(steps.size(), 4 * period);
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t begin = 0; begin + window <= steps.size(); ++begin) {
    std::vector<std::vector<double>> ratios(period);
    for (std::size_t i = 0; i < window; ++i) ratios[i % period].push_back(steps[begin + i].log_ratio);
    const std::vector<double> to_next = medians(ratios);
    double deviation = 0;
    for (std::size_t i = 0; i < window; ++i)
      deviation += std::abs(steps[begin + i].log_ratio - to_next[i % period]);
    if (deviation < least) least = deviation, best = around_mean(to_next);
  }
  return best;
}

// By the walk that such exposures would make.
std::vector<double> refined(std::span<const CycleStep> steps, std::span<const double> log_exposures) {
  const Path path = cheapest(steps, log_exposures, 1);
  std::vector<std::vector<double>> ratios(log_exposures.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto from = static_cast<std::size_t>(path.walk.slots[i]),
               to = static_cast<std::size_t>(path.walk.slots[i + 1]);
    if (to == (from + 1) % log_exposures.size()) ratios[from].push_back(steps[i].log_ratio);
  }
  return around_mean(medians(ratios));
}

// A size, ln, that most steps are below. Half of a cycle's steps may be none, as of one long exposure among
// four; losses leave a part of those over a whole cycle large.
double usual_size(std::span<const CycleStep> steps) {
  std::vector<double> sizes;
  for (const CycleStep& step : steps) sizes.push_back(std::abs(step.log_ratio));
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 3 / 5);
  std::ranges::nth_element(sizes, at);
  return *at;
}

// After how many frames the exposures repeat; 0 where they do not. Neighbours in a cycle of small steps
// differ by no more than frames of one exposure may, but frames a whole cycle apart by far less.
std::size_t period_of(const StepsByLag& steps) {
  constexpr double kFarLess = 0.4;
  std::size_t period = 0;
  double least = std::numeric_limits<double>::infinity();  // of shorter lags
  for (std::size_t lag = 1; lag <= steps.size(); ++lag) {
    if (steps[lag - 1].empty()) continue;
    const double size = usual_size(steps[lag - 1]);
    if (size < kSameInFootage && size < kFarLess * least && least > kSameExposure) period = lag;
    least = std::min(least, size);
  }
  return period;
}

}  // namespace

CycleStep step_between(Photometer& photometer, const PhotometricSignature& earlier,
                       const PhotometricSignature& later) {
  if (const auto ratio = photometer.ratio(earlier, later)) return {StepKind::Measured, ratio->log_ratio};
  return rough_step(earlier, later);
}

CycleStep rough_step(const PhotometricSignature& earlier, const PhotometricSignature& later) {
  return {StepKind::Rough, brightness_of(later) - brightness_of(earlier)};
}

Result<CycleWalk> find_walk(std::span<const CycleStep> steps, std::span<const Exposure> cycle) {
  TRY(check_slots(cycle));
  std::vector<double> log_exposures;
  for (const Exposure& exposure : cycle) log_exposures.push_back(log_product(exposure));
  Path best = best_path(steps, log_exposures);
  count_losses(steps, static_cast<int>(cycle.size()), best.walk);
  best.walk.mean_residual = steps.empty() ? 0 : best.cost / static_cast<double>(steps.size());
  if (best.walk.mean_residual > kAcceptedResidual || (cycle.size() > 1 && !explains(best, steps)))
    return Error{
        ErrorCode::BadExposure,
        fmt::format(
            "{}; give the camera's own cycle, or --shutter auto",
            cycle.size() == 1
                ? fmt::format("the exposure changes between frames, and is not always {}", describe(cycle))
                : fmt::format("the pictures do not alternate as {} would", describe(cycle)))};
  if (is_out_of_order(best.walk, steps, log_exposures))
    return Error{ErrorCode::BadExposure,
                 fmt::format("the pictures get darker where {} gets brighter, or the reverse; give the "
                             "exposures in the camera's order, or --shutter auto",
                             describe(cycle))};
  return best.walk;
}

int count_copies(std::span<const CycleStep> steps, std::span<const Exposure> cycle) {
  for (std::size_t i = 0; i < cycle.size(); ++i) {
    const Exposure& next = cycle[(i + 1) % cycle.size()];
    if (std::abs(log_product(next) - log_product(cycle[i])) <= kSameInFootage) return 0;
  }
  const auto is_copied = [](const CycleStep& step) {
    return step.kind == StepKind::Measured && step.missing == 0 && std::abs(step.log_ratio) <= kSameExposure;
  };
  return static_cast<int>(std::ranges::count_if(steps, is_copied));
}

Result<std::vector<Exposure>> estimate_cycle(const StepsByLag& steps) {
  constexpr int kRounds = 3;  // of refinement
  const std::size_t period = period_of(steps);
  if (period == 0)
    return Error{
        ErrorCode::BadExposure,
        fmt::format("the pictures show no cycle of 1 to {} exposures; give it with --shutter", steps.size())};
  std::vector<double> log_exposures = first_guess(steps[0], period);
  for (int round = 0; round < kRounds; ++round) log_exposures = refined(steps[0], log_exposures);
  std::vector<Exposure> cycle;
  cycle.reserve(log_exposures.size());
  for (const double log_exposure : log_exposures)
    cycle.push_back({from_seconds(kReference_s * std::exp(log_exposure)), 1});
  return cycle;
}

}  // namespace hdrcam
