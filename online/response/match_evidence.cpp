#include "online/response/match_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "capture/clip_policy.h"
#include "capture/exposed_frame.h"

namespace hdrcam {
namespace {

// Variance of g where a code is matched: of its quantisation and of its noise.
double variance_of(const Knots& code, const Eigen::VectorXd& g, const MatchNoise& noise) {
  constexpr int kFullKnot = 250;           // code 251: its light is 1 for the noise
  constexpr double kWidened = 2;           // how far noise that widens a histogram moves its quantiles
  constexpr double kLeftByMedians = 0.18;  // of the variance of white noise (neighbour_medians.h)
  const double slope = code.slope(g), x = std::exp(code.of(g) - g[kFullKnot]);
  const double relative = static_cast<double>(noise.model.exposure_variance(static_cast<float>(x))) / (x * x);
  // where steps are even in light there is no one step of a code
  const double step = noise.model.code_step > 0 ? static_cast<double>(noise.model.code_step) : 1;
  const double quantised = slope * slope * step * step / 12;
  if (!noise.is_own) return quantised + 0.5 * relative;
  const double left = kLeftByMedians * relative;
  return quantised + 0.5 * left + kWidened * left * left;
}

// g at one code less g at another.
std::array<Term, 4> difference_of(const Knots& a, const Knots& b) {
  return {
      Term{a.lo, 1 - a.fraction}, {a.lo + 1, a.fraction}, {b.lo, b.fraction - 1}, {b.lo + 1, -b.fraction}};
}

// The equations that one pair of exposures makes of its codes: g(a) - g(b) = ln E1/E2.
struct PairOfExposures {
  Eigen::Index shorter, longer;  // places among the shared
  double stated, log_ratio;      // ln E1/E2, as stated and as fitted
  double scale;                  // of the weights

  // By how much the curve misses it.
  double rest(const Knots& a, const Knots& b, const Eigen::VectorXd& g) const {
    return a.of(g) - b.of(g) - log_ratio;
  }
  void add(double weight, const Knots& a, const Knots& b, double target, CurveSquares& squares) const {
    const std::array<Term, 2> of_exposures{Term{shorter, -1}, {longer, 1}};
    squares.add(weight, target, difference_of(a, b), of_exposures);
  }
};

float without_black(float code, float black_level) {
  return (code - black_level) * (kMaxCode / (kMaxCode - black_level));
}

// One entry of a channel's matches, and its places among what the channels share.
PairOfExposures pair_of(const HistogramMatches::OfChannel::value_type& entry,
                        const shared_unknowns::Values& shared) {
  constexpr double kMatchWeight = 0.2;         // because quantiles are not independent
  constexpr double kMaxWeightPerRatio = 1000;  // matches of one exposure ratio count as at most this many
  const auto& [key, matches] = entry;
  const Eigen::Index shorter = shared_unknowns::place_of(key.first, shared.keys),
                     longer = shared_unknowns::place_of(key.second, shared.keys);
  const double count = std::max(1.0, static_cast<double>(matches.codes.size()));
  return {.shorter = shorter,
          .longer = longer,
          .stated = matches.log_ratio,
          .log_ratio = matches.log_ratio + shared.e[shorter] - shared.e[longer],
          .scale = kMatchWeight * std::min(1.0, kMaxWeightPerRatio / count)};
}

// Whether the light of a code of the shorter exposure is at least, or at most, that of one of the longer.
enum class Side { AtLeast, AtMost };

struct Bound {
  Side side;
  float code, other;  // without black
  double tolerance;   // ln x
};

// Adds one of so many bounds where the curve breaks it; returns its misfit.
double add_bound(const Bound& bound, std::size_t bounds, const PairOfExposures& pair, const MatchNoise& noise,
                 const Eigen::VectorXd& g, CurveSquares& squares) {
  constexpr double kSigma = 0.1, kMatches = 20;  // ln x; a bound counts like so many
  // ln x: how far beyond its bound the curve may be, however many frames show the bound. Of the prior cut off
  // at the bound of a toe the deviation beyond it is that of one measurement of .7 to .85.
  constexpr double kBeyond = 0.75;
  const double side = bound.side == Side::AtLeast ? 1 : -1;
  const Knots code(static_cast<double>(bound.code)), other(static_cast<double>(bound.other));
  const double r = side * pair.rest(code, other, g) + bound.tolerance;
  if (r >= 0) return 0;
  const double w = kMatches * pair.scale / (kSigma * kSigma + variance_of(code, g, noise));
  const double told = 1 / (kBeyond * kBeyond * static_cast<double>(bounds));
  pair.add(w, code, other, pair.stated - side * bound.tolerance, squares);
  squares.holds.push_back({std::max(0.0, w - told), difference_of(code, other)});
  return w * r * r;
}

}  // namespace

double add_match_evidence(const HistogramMatches::OfChannel& channel, float black_level,
                          const MatchNoise& noise, const Eigen::VectorXd& g,
                          const shared_unknowns::Values& shared, CurveSquares& squares) {
  // ln x: motion between the frames moves the quantiles, and so does compression
  constexpr double kSigmaOfOwnNoise = 0.03, kSigma = 0.06;
  const double match_sigma = noise.is_own ? kSigmaOfOwnNoise : kSigma;
  constexpr double kCauchy2 = 4;  // squared scale of the robust weight, in sigmas
  const auto [first, last] = clip_policy::kResponseMatch;
  double misfit = 0;
  for (const auto& entry : channel) {
    const std::vector<CodeMatch>& codes = entry.second.codes;
    if (codes.empty()) continue;
    const PairOfExposures pair = pair_of(entry, shared);
    double sum = 0, used = 0, usable = 0;
    for (const CodeMatch& match : codes) {
      const float z1 = without_black(match.z1, black_level), z2 = without_black(match.z2, black_level);
      usable += match.z1 >= first && match.z2 <= last ? 1 : 0;
      if (z1 < first || z2 > last) continue;
      const Knots k1(static_cast<double>(z1)), k2(static_cast<double>(z2));
      const double r = pair.rest(k1, k2, g);
      const double s2 = match_sigma * match_sigma + variance_of(k1, g, noise) + variance_of(k2, g, noise);
      const double w = pair.scale / s2 / (1 + r * r / (s2 * kCauchy2));
      sum += pair.scale * kCauchy2 * std::log1p(r * r / (s2 * kCauchy2));
      used += 1;
      pair.add(w, k1, k2, pair.stated, squares);
    }
    // matches that a higher black level drops count like the mean of the others, so that dropping gives no
    // advantage
    if (used > 0) misfit += sum * std::max(used, usable) / used;
  }
  return misfit;
}

double add_white_bounds(const HistogramMatches::OfChannel& channel, float black_level,
                        const MatchNoise& noise, const Eigen::VectorXd& g,
                        const shared_unknowns::Values& shared, CurveSquares& squares) {
  constexpr double kTolerance = 0.3;  // ln x: white may be less, by compression and motion
  const float white = without_black(clip_policy::kResponseMatch.brightest, black_level);
  double misfit = 0;
  for (const auto& entry : channel) {
    const std::vector<float>& codes = entry.second.white_from;
    if (codes.empty()) continue;
    const PairOfExposures pair = pair_of(entry, shared);
    for (const float code : codes)
      misfit += add_bound({Side::AtLeast, without_black(code, black_level), white, kTolerance}, codes.size(),
                          pair, noise, g, squares);
  }
  return misfit;
}

double add_dark_bounds(const HistogramMatches::OfChannel& channel, float black_level, const MatchNoise& noise,
                       const Eigen::VectorXd& g, const shared_unknowns::Values& shared,
                       CurveSquares& squares) {
  // ln x: a short exposure's noise, and its compression, make dark codes brighter, too
  constexpr double kTolerance = 1;
  const float darkest = clip_policy::kResponseMatch.darkest;
  double misfit = 0;
  for (const auto& entry : channel) {
    const std::vector<CodeMatch>& codes = entry.second.dark_to;
    if (codes.empty()) continue;
    const PairOfExposures pair = pair_of(entry, shared);
    for (const CodeMatch& dark : codes) {
      const float z1 = without_black(dark.z1, black_level), z2 = without_black(dark.z2, black_level);
      if (z1 < darkest || z2 < darkest) continue;
      misfit += add_bound({Side::AtMost, z1, z2, kTolerance}, codes.size(), pair, noise, g, squares);
    }
  }
  return misfit;
}

}  // namespace hdrcam
