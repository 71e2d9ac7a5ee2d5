#include "online/response/response_estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "online/response/black_level_search.h"
#include "online/response/curve_network.h"
#include "online/response/curve_prior.h"
#include "online/response/curve_squares.h"
#include "online/response/match_evidence.h"
#include "online/response/noise_evidence.h"
#include "online/response/shared_unknowns.h"

namespace hdrcam {
namespace {

constexpr int kGaugeKnot = 127;       // where g is fixed: a common factor of x is not observable
constexpr double kGaugeWeight = 1e4;  // of that equation, 1 / (ln x)^2
constexpr int kIterations = 4;        // of the robust fit to matches
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

// body(channel), on the threads of the pool if there is one.
template <class Body>
void for_each_channel(WorkerPool* pool, Body&& body) {
  auto of_index = [&](int c) { body(static_cast<std::size_t>(c)); };
  if (pool != nullptr) return pool->for_each(3, of_index);
  for (int c = 0; c < 3; ++c) of_index(c);
}

std::array<Response::Curve, 3> curves_of(const std::array<Vector, 3>& g) {
  std::array<Response::Curve, 3> inverse;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int z = 0; z < kKnots; ++z)
      inverse[c][static_cast<std::size_t>(z) + 1] = static_cast<float>(std::exp(g[c][z] - g[c][kKnots - 1]));
    inverse[c][0] = 0.5f * inverse[c][1];
  }
  return inverse;
}

// All of the spread of a sensor's own codes is shot, read and quantisation noise.
NoiseModel noise_model(const SensorNoise& noise, float code_step) {
  constexpr float kCodeNoise = 0.1f;  // codes
  return {static_cast<float>(noise.full_well_electrons()), static_cast<float>(noise.read_noise_electrons()),
          kCodeNoise, code_step};
}

// A channel's evidence and prior, and the misfit of the curve at which they were made linear.
struct Agreement : CurveSquares {
  CurveMisfit misfit;

  using CurveSquares::CurveSquares;
};

// shared: of all exposures.
Agreement agreement(const HistogramMatches::OfChannel& matches, float black_level, const MatchNoise& noise,
                    const Vector& g, const shared_unknowns::Values& shared) {
  const CurvePrior& prior = curve_prior();
  Agreement agreed(shared_unknowns::count(shared.keys));
  agreed.A = prior.precision, agreed.b = prior.precision * prior.mean;
  agreed.A(kGaugeKnot, kGaugeKnot) += kGaugeWeight;
  agreed.misfit.of_matches = add_match_evidence(matches, black_level, noise, g, shared, agreed) +
                             add_white_bounds(matches, black_level, noise, g, shared, agreed) +
                             add_dark_bounds(matches, black_level, noise, g, shared, agreed);
  const Vector d = g - prior.mean;
  agreed.misfit.of_prior = d.dot(prior.precision * d);
  return agreed;
}

// What the channels share.
struct SharedFit {
  Vector shared;                   // shared_unknowns.h
  std::optional<NoiseModel> seen;  // where the frames show the sensor's own

  SensorNoise noise() const {
    return {shared[shared_unknowns::kFullWell], shared[shared_unknowns::kReadNoise]};
  }
};

// All channels, and what they share.
struct Fit : SharedFit {
  struct Curve {
    Vector g;
    Matrix precision;  // of g, given the matches, the prior and what the channels share
  };
  std::array<Curve, 3> curves;
};

// What a channel says of the shared e: e'Q e - 2 q'e, without a constant.
struct SharedSquares {
  Matrix Q;
  Vector q;
};

// A channel's equations without its curve, which goes by the shared.
struct CurveOfShared {
  Vector alone;
  Matrix change;  // with the shared
  SharedSquares shared;

  explicit CurveOfShared(const CurveSquares& squares) {
    const Eigen::LLT<Matrix> factor(squares.A);
    alone = factor.solve(squares.b), change = factor.solve(squares.B);
    shared = {squares.C - squares.B.transpose() * change, squares.d - change.transpose() * squares.b};
  }
  Vector at(const Vector& e) const {
    Vector g = alone - change * e;
    make_rising(g);
    return g;
  }
};

// The shared unknowns on which channels and the prior agree best.
Vector agreed_on(const Matrix& prior_precision, std::span<const SharedSquares> channels) {
  Matrix Q = prior_precision;
  Vector q = Vector::Zero(Q.rows());
  for (const SharedSquares& channel : channels) Q += channel.Q, q += channel.q;
  return Q.ldlt().solve(q);
}

// Of the curve of one channel, and of what stated exposures are off, that fit best at this black level.
CurveMisfit misfit_at(float black_level, const HistogramMatches::OfChannel& matches,
                      const std::vector<int>& keys, const NoiseModel& noise) {
  const Matrix prior = shared_unknowns::prior_precision(keys, shared_unknowns::Curves::Fitted);
  Vector g = curve_prior().mean, e = Vector::Zero(prior.rows());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const CurveOfShared curve(agreement(matches, black_level, {noise}, g, {keys, e}));
    e = agreed_on(prior, {&curve.shared, 1});
    g = curve.at(e);
  }
  CurveMisfit misfit = agreement(matches, black_level, {noise}, g, {keys, e}).misfit;
  misfit.of_matches += e.dot(prior * e);
  return misfit;
}

bool shows_noise(const std::array<std::vector<NoiseLevel>, 3>& levels) {
  return std::any_of(levels.begin(), levels.end(), [](const auto& channel) { return !channel.empty(); });
}

// Curves and what they share together: each channel's curve is eliminated from the equations of the shared.
Fit solve(const HistogramMatches& matches, const std::array<std::vector<NoiseLevel>, 3>& levels,
          const BlackLevel& black_level, const NoiseModel& noise, WorkerPool* pool) {
  constexpr int kIterationsWithNoise = 12;  // it may lead far from the mean of real cameras
  const std::vector<int> keys = matches.exposure_keys();
  const bool noise_shown = shows_noise(levels);
  const Matrix shared_precision = shared_unknowns::prior_precision(keys, shared_unknowns::Curves::Fitted);
  Fit fit{{Vector::Zero(shared_precision.rows()), {}}, {}};
  for (Fit::Curve& curve : fit.curves) curve = {curve_prior().mean, {}};
  for (int iteration = 0; iteration < (noise_shown ? kIterationsWithNoise : kIterations); ++iteration) {
    std::array<std::optional<CurveOfShared>, 3> curves;
    std::array<SharedSquares, 3> of_shared;
    for_each_channel(pool, [&](std::size_t c) {
      Fit::Curve& curve = fit.curves[c];
      const MatchNoise of_matches{fit.seen.value_or(noise), fit.seen.has_value()};
      Agreement agreed = agreement(matches.of(c), black_level[c], of_matches, curve.g, {keys, fit.shared});
      add_noise_evidence(levels[c], black_level[c], curve.g, fit.noise(), shared_unknowns::kFullWell, agreed);
      of_shared[c] = curves[c].emplace(agreed).shared;
      curve.precision = std::move(agreed).take_precision();
    });
    fit.shared = agreed_on(shared_precision, of_shared);
    for (std::size_t c = 0; c < 3; ++c) fit.curves[c].g = curves[c]->at(fit.shared);
    if (noise_shown) fit.seen = noise_model(fit.noise(), noise.code_step);
  }
  return fit;
}

// Where the curves are known and codes have no black level.
SharedFit solve_shared(const HistogramMatches& matches, const std::array<std::vector<NoiseLevel>, 3>& levels,
                       const Response& known, const NoiseModel& noise, WorkerPool* pool) {
  // Until the frames show it, as much noise as small sensors have: that of dark frames matches, too, and
  // would be taken for light.
  const NoiseModel doubtful{
      .full_well = 2000, .read_noise = 8, .code_noise = noise.code_noise, .code_step = noise.code_step};
  const std::vector<int> keys = matches.exposure_keys();
  const bool noise_shown = shows_noise(levels);
  const Matrix prior = shared_unknowns::prior_precision(keys, shared_unknowns::Curves::Known);
  std::array<Vector, 3> g;
  for (std::size_t c = 0; c < 3; ++c) {
    g[c].resize(kKnots);
    const Response::Curve& inverse = known.inverse(static_cast<int>(c));
    for (int z = 0; z < kKnots; ++z)
      g[c][z] = std::log(static_cast<double>(inverse[static_cast<std::size_t>(z) + 1]));
  }
  SharedFit fit{Vector::Zero(prior.rows()), {}};
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::array<SharedSquares, 3> of_shared;
    for_each_channel(pool, [&](std::size_t c) {
      CurveSquares squares(prior.rows());
      const MatchNoise of_matches{fit.seen.value_or(doubtful), true};
      add_match_evidence(matches.of(c), 0, of_matches, g[c], {keys, fit.shared}, squares);
      add_noise_evidence(levels[c], 0, g[c], fit.noise(), shared_unknowns::kFullWell, squares);
      of_shared[c] = {std::move(squares.C), squares.d - squares.B.transpose() * g[c]};
    });
    fit.shared = agreed_on(prior, of_shared);
    if (noise_shown) fit.seen = noise_model(fit.noise(), noise.code_step);
  }
  return fit;
}

// The posterior deviation of ln x against the middle code, where the gauge is fixed.
std::array<Response::Curve, 3> uncertainty_of(const Fit& fit, WorkerPool* pool) {
  std::array<Response::Curve, 3> uncertainty;
  for_each_channel(pool, [&](std::size_t c) {
    const Vector variance =
        fit.curves[c].precision.llt().solve(Matrix::Identity(kKnots, kKnots)).diagonal().cwiseMax(0);
    for (int z = 0; z < kKnots; ++z)
      uncertainty[c][static_cast<std::size_t>(z) + 1] = static_cast<float>(std::sqrt(variance[z]));
    uncertainty[c][0] = uncertainty[c][1];
  });
  return uncertainty;
}

// Exposures as stated. Its first curves break bounds of what is dark, which would lead it astray.
Response network_response(const HistogramMatches& matches, const BlackLevel& black, const NoiseModel& noise) {
  const std::vector<int> keys = matches.exposure_keys();
  const Vector as_stated = Vector::Zero(shared_unknowns::count(keys));
  std::array<Vector, 3> g;
  for (std::size_t c = 0; c < 3; ++c)
    g[c] = fit_curve_network(curve_prior().mean, [&](const Vector& at, Matrix& A, Vector& b) {
      CurveSquares squares(as_stated.size());
      add_match_evidence(matches.of(c), black[c], {noise}, at, {keys, as_stated}, squares);
      add_white_bounds(matches.of(c), black[c], {noise}, at, {keys, as_stated}, squares);
      A = std::move(squares.A), b = std::move(squares.b);
    });
  return Response(curves_of(g));
}

// What histograms match codes near a smeared white with is brighter than the curve there, in each channel by
// another factor; what they match lower codes with leads to white by the curves of real cameras. The curves
// stay: of such a code the brighter light is the one to expect.
std::optional<ChannelGains> neutral_gains(const HistogramMatches& matches, const Fit& fit) {
  constexpr double kSmeared = 0.02;  // of the white pixels; without compression or demosaicing below .01
  constexpr int kLastUsed = 215;     // code
  constexpr double kMost = 1.4;      // ln x: two stops; what seems to be more is no smear
  double smeared = 0;
  for (std::size_t c = 0; c < 3; ++c) smeared = std::max(smeared, matches.smeared_white(c).share());
  if (smeared <= kSmeared) return std::nullopt;
  Eigen::Vector3d beyond;  // ln x: by how much the curve's white is brighter than the expected one
  for (std::size_t c = 0; c < 3; ++c) {
    const Vector& g = fit.curves[c].g;
    beyond[static_cast<Eigen::Index>(c)] = g[kKnots - 1] - expected_white(g, kLastUsed);
  }
  ChannelGains gains;
  const Eigen::Array3d apart = (beyond.array() - beyond.mean()).max(-kMost).min(kMost);
  Eigen::Map<Eigen::Array3d>(gains.data()) = (apart - apart.mean()).exp();
  return gains;
}

ExposureCorrections corrections_of(const Vector& shared, const HistogramMatches& matches) {
  ExposureCorrections exposures;
  Eigen::Index at = shared_unknowns::kExposures;  // ascending, as the keys
  for (const auto& [key, stated] : matches.exposures()) exposures.set(stated, shared[at++]);
  return exposures;
}

}  // namespace

ResponseEstimate ResponseEstimator::estimate_under(const Response& known, const NoiseModel& noise,
                                                   WorkerPool* pool) const {
  const SharedFit fit = solve_shared(matches_, noise_levels_.levels(), known, noise, pool);
  return {known, {}, corrections_of(fit.shared, matches_), fit.seen};
}

ResponseEstimate ResponseEstimator::estimate(const NoiseModel& noise, ResponseModel model,
                                             WorkerPool* pool) const {
  const BlackLevel black = stated_black_ ? *stated_black_ : found_black(noise, pool);
  switch (model) {
    case ResponseModel::Linear:
      return {Response::linear(), black, {}, {}};
    case ResponseModel::Mean:
      return {prior_mean_response(), black, {}, {}};
    case ResponseModel::Network:
      return {network_response(matches_, black, noise), black, {}, {}};
    case ResponseModel::Curve:
      break;
  }
  const Fit fit = solve(matches_, noise_levels_.levels(), black, noise, pool);
  const auto& [red, green, blue] = fit.curves;
  return {Response(curves_of({red.g, green.g, blue.g}), uncertainty_of(fit, pool)), black,
          corrections_of(fit.shared, matches_), fit.seen, neutral_gains(matches_, fit)};
}

BlackLevel ResponseEstimator::found_black(const NoiseModel& noise, WorkerPool* pool) const {
  const std::vector<int> keys = matches_.exposure_keys();
  const auto find = [&](std::size_t c, const OtherBlackLevels& others) {
    return find_black_level(
        matches_.darkest(c), matches_.most_black(c),
        [&](float level) { return misfit_at(level, matches_.of(c), keys, noise); }, others);
  };
  std::array<float, 3> found;
  for_each_channel(pool, [&](std::size_t c) { found[c] = find(c, {}); });
  OtherBlackLevels others;  // of a channel that has none
  for (const float level : found)
    if (level > 0) ++others.found, others.mean += level;
  if (others.found == 1 || others.found == 2) {
    others.mean /= static_cast<float>(others.found);
    for_each_channel(pool, [&](std::size_t c) {
      if (found[c] <= 0) found[c] = find(c, others);
    });
  }
  BlackLevel black;
  for (std::size_t c = 0; c < 3; ++c) black.set(c, found[c]);
  return black;
}

Response prior_mean_response() {
  const Vector& mean = curve_prior().mean;
  return Response(curves_of({mean, mean, mean}));
}

}  // namespace hdrcam
