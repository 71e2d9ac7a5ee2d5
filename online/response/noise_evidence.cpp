#include "online/response/noise_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "capture/exposed_frame.h"
#include "hal/core/median.h"

namespace hdrcam {
namespace {

// One level, as an equation in ln: what curve and noise predict less what it says.
struct Equation {
  double rest;
  double sigma2;
  std::array<Term, 7> of_curve;
  std::array<Term, 2> of_noise;
};

// None of a level whose code is not well within the curve.
std::optional<Equation> equation_of(const NoiseLevel& level, float black_level, const Eigen::VectorXd& g,
                                    const SensorNoise& noise, Eigen::Index full_well_at) {
  constexpr double kReach = 0.1;       // of a code: its slope is that over so much on both sides
  constexpr double kLeastRise = 1e-4;  // of g
  const double stretch = static_cast<double>(kMaxCode / (kMaxCode - black_level));
  const double code = static_cast<double>(level.code - black_level) * stretch;
  const double reach = std::max(1.0, kReach * code);
  if (code - reach < 1 || code + reach > static_cast<double>(kMaxCode)) return {};
  const Knots before(code - reach), here(code), after(code + reach);
  const double rise = std::max(kLeastRise, after.of(g) - before.of(g));
  const double light = std::exp(here.of(g) - g[kKnots - 1]);
  const double full_well = noise.full_well_electrons(), read = noise.read_noise_electrons() / full_well;
  const double shot = light / full_well, variance = shot + read * read, shot_share = shot / variance;
  // spread = sqrt(variance) / (dx/dz), and dx/dz = light * dg/dz
  const double rest = std::log(variance) / 2 - std::log(light * rise / (2 * reach)) -
                      std::log(static_cast<double>(level.spread) * stretch);
  const double of_light = shot_share / 2 - 1, error = static_cast<double>(level.error);
  return Equation{rest,
                  error * error,
                  {Term{before.lo, (1 - before.fraction) / rise},
                   {before.lo + 1, before.fraction / rise},
                   {after.lo, -(1 - after.fraction) / rise},
                   {after.lo + 1, -after.fraction / rise},
                   {here.lo, of_light * (1 - here.fraction)},
                   {here.lo + 1, of_light * here.fraction},
                   {kKnots - 1, -of_light}},
                  {Term{full_well_at, shot_share / 2 - 1}, {full_well_at + 1, 1 - shot_share}}};
}

}  // namespace

double SensorNoise::full_well_electrons() const { return kUsualFullWell * std::exp(full_well); }
double SensorNoise::read_noise_electrons() const { return kUsualReadNoise * std::exp(read_noise); }

void add_noise_evidence(const std::vector<NoiseLevel>& levels, float black_level, const Eigen::VectorXd& g,
                        const SensorNoise& noise, Eigen::Index full_well_at, CurveSquares& squares) {
  constexpr double kCauchy2 = 4;   // squared scale of the robust weight, in sigmas
  constexpr double kFarthest = 1;  // in ln: what one step may ask for
  std::vector<Equation> equations;
  std::vector<double> rests2;
  for (const NoiseLevel& level : levels) {
    const auto equation = equation_of(level, black_level, g, noise, full_well_at);
    if (!equation) continue;
    equations.push_back(*equation);
    rests2.push_back(equation->rest * equation->rest);
  }
  if (equations.empty()) return;
  // far from the solution all levels disagree, and none is an outlier for it
  const double middle = median(rests2);
  for (const Equation& e : equations) {
    const double rest = std::clamp(e.rest, -kFarthest, kFarthest);
    const double weight = 1 / e.sigma2 / (1 + rest * rest / (kCauchy2 * std::max(e.sigma2, middle)));
    double target = e.of_noise[0].factor * noise.full_well + e.of_noise[1].factor * noise.read_noise - rest;
    for (const Term& term : e.of_curve) target += term.factor * g[term.at];
    squares.add(weight, target, e.of_curve, e.of_noise);
  }
}

}  // namespace hdrcam
