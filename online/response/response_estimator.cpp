#include "online/response/response_estimator.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "capture/clip_policy.h"
#include "hal/core/median.h"
#include "online/response/curve_network.h"
#include "online/response/curve_squares.h"
#include "online/response/float_order.h"
#include "online/response/noise_evidence.h"

namespace hdrcam {
namespace {

#include "online/response/dorf_prior.inc"

constexpr int kGaugeKnot = 127;  // where g is fixed: a common factor of x is not observable
constexpr int kIterations = 4;   // of the robust fit to matches
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

// Gaussian prior of g: real cameras (mean and principal directions), a smooth free part for other cameras,
// and a small independent part per code.
struct Prior {
  Vector mean = Vector::Zero(kKnots);
  Matrix precision;

  Prior() {
    constexpr double kFreeSigma = 0.06;   // ln x
    constexpr double kFreeWidth = 0.5;    // in ln z
    constexpr double kCodeSigma = 0.004;  // ln x
    Matrix covariance = Matrix::Zero(kKnots, kKnots);
    for (int i = 0; i < kKnots; ++i) mean[i] = static_cast<double>(kDorfMean[i]);
    for (const auto& direction : kDorfDirection) {
      Vector d(kKnots);
      for (int i = 0; i < kKnots; ++i) d[i] = static_cast<double>(direction[i]);
      covariance.noalias() += d * d.transpose();
    }
    for (int i = 0; i < kKnots; ++i) {
      for (int j = 0; j < kKnots; ++j) {
        const double d = (std::log(i + 6.0) - std::log(j + 6.0)) / kFreeWidth;
        covariance(i, j) += kFreeSigma * kFreeSigma * std::exp(-d * d / 2);
      }
      covariance(i, i) += kCodeSigma * kCodeSigma;
    }
    precision = covariance.llt().solve(Matrix::Identity(kKnots, kKnots));
  }
};

const Prior& prior() {
  static const Prior kPrior;
  return kPrior;
}

void make_monotone(Vector& g) {
  for (int z = 1; z < kKnots; ++z) g[z] = std::max(g[z], g[z - 1] + 1e-4);
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

// What the channels share: the noise of the sensor, then what exposures are off, in ln.
constexpr Eigen::Index kFullWell = 0, kReadNoise = 1, kExposures = 2;

// Its prior. Nominal times are within a sixth of a stop of the true ones, mostly within a twentieth. All
// exposures to a power, and the curve to the same, explain the same matches: which power it is only real
// cameras tell, so exposures are not bent that way.
Matrix precision_of_shared(const std::vector<int>& keys) {
  constexpr double kSigma = 0.06 * 0.69314718056;  // ln, of .06 stop
  constexpr double kUnbent = 1e6;
  const auto n = static_cast<Eigen::Index>(keys.size());
  Matrix precision = Matrix::Identity(kExposures + n, kExposures + n) / (kSigma * kSigma);
  precision(kFullWell, kFullWell) = std::pow(SensorNoise::kFullWellSigma, -2);
  precision(kReadNoise, kReadNoise) = std::pow(SensorNoise::kReadNoiseSigma, -2);
  Vector power(n);
  for (Eigen::Index k = 0; k < n; ++k) power[k] = keys[static_cast<std::size_t>(k)];
  if (n > 0) power.array() -= power.mean();
  if (power.norm() > 0)
    precision.bottomRightCorner(n, n) += kUnbent * power * power.transpose() / power.squaredNorm();
  return precision;
}

Eigen::Index shared_count(const std::vector<int>& keys) {
  return kExposures + static_cast<Eigen::Index>(keys.size());
}

// All of the spread of a sensor's own codes is shot, read and quantisation noise.
NoiseModel noise_model(const SensorNoise& noise, float code_step) {
  constexpr float kCodeNoise = 0.1f;  // codes
  return {static_cast<float>(noise.full_well_electrons()), static_cast<float>(noise.read_noise_electrons()),
          kCodeNoise, code_step};
}

// Of large pictures every n-th line tells as much.
int line_step(const Image<float>& codes) {
  constexpr std::size_t kEnoughPixels = 200'000;
  return static_cast<int>((codes.plane_size() + kEnoughPixels - 1) / kEnoughPixels);
}

// Medians of green over a coarse grid, -1 where they are clipped: two pictures of one scene agree in them up
// to a monotone curve, whatever lies between the exposures. Means do not: lamps and saturation move them.
std::vector<float> thumbnail(const ExposedFrame& frame) {
  constexpr int kCells = 16;
  std::vector<float> cells, cell;
  const auto& codes = frame.codes;
  const int step = line_step(codes);
  for (int gy = 0; gy < kCells; ++gy)
    for (int gx = 0; gx < kCells; ++gx) {
      const int y0 = codes.rows() * gy / kCells, y1 = std::max(y0 + 1, codes.rows() * (gy + 1) / kCells);
      const int x0 = codes.cols() * gx / kCells, x1 = std::max(x0 + 1, codes.cols() * (gx + 1) / kCells);
      cell.clear();
      for (int y = y0; y < std::min(y1, codes.rows()); y += step)
        for (int x = x0; x < std::min(x1, codes.cols()); ++x) cell.push_back(codes.at(1, y, x));
      const float middle = median(cell);
      const auto [darkest, brightest] = clip_policy::kSameScene;
      cells.push_back(middle < darkest || middle > brightest ? -1 : middle);
    }
  return cells;
}

// Spearman's rank correlation over the cells that are clipped in neither picture; 1 when too few are left.
double rank_correlation(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<std::size_t> both;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] >= 0 && b[i] >= 0) both.push_back(i);
  if (both.size() < 24) return 1;
  const auto ranks = [&](const std::vector<float>& v) {
    std::vector<std::size_t> order(both.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return v[both[i]] < v[both[j]]; });
    std::vector<double> rank(both.size());
    for (std::size_t r = 0; r < order.size(); ++r) rank[order[r]] = static_cast<double>(r);
    return rank;
  };
  const auto ra = ranks(a), rb = ranks(b);
  const double n = static_cast<double>(both.size());
  double square = 0;
  for (std::size_t i = 0; i < ra.size(); ++i) square += (ra[i] - rb[i]) * (ra[i] - rb[i]);
  return 1 - 6 * square / (n * (n * n - 1));
}

// A sorted channel that gives the place of its codes in the histogram.
class Ranking {
 public:
  Ranking(const ExposedFrame& frame, int channel, std::vector<float>& scratch) {
    const auto& codes = frame.codes;
    const int step = line_step(codes);
    codes_.reserve(codes.plane_size() / static_cast<std::size_t>(step) +
                   static_cast<std::size_t>(codes.cols()));
    for (int y = 0; y < codes.rows(); y += step)
      codes_.insert(codes_.end(), codes.row(channel, y), codes.row(channel, y) + codes.cols());
    sort_floats(codes_, scratch);
  }

  struct Boundary {
    double code;   // midway between two neighbouring codes
    double share;  // of the pixels that are darker
  };
  // The boundary between codes that is nearest to this share of the pixels.
  Boundary boundary_near(double share) const {
    const Plateau p = plateau(share);
    const double below = static_cast<double>(p.begin) / size(), above = static_cast<double>(p.end) / size();
    return share - below < above - share ? Boundary{p.lower, below} : Boundary{p.upper, above};
  }
  // The code below which this share of the pixels lies, linear within one code.
  double code_at(double share) const {
    const Plateau p = plateau(share);
    const double within =
        (share * size() - static_cast<double>(p.begin)) / static_cast<double>(p.end - p.begin);
    return p.lower + (p.upper - p.lower) * std::clamp(within, 0.0, 1.0);
  }
  float quantile(double share) const { return codes_[index(share)]; }

 private:
  struct Plateau {
    std::size_t begin, end;  // the pixels of one code
    double lower, upper;     // its boundaries
  };
  Plateau plateau(double share) const {
    const float code = codes_[index(share)];
    const auto [first, last] = std::equal_range(codes_.begin(), codes_.end(), code);
    const auto z = static_cast<double>(code);
    const double lower = first == codes_.begin() ? z - 0.5 : (z + static_cast<double>(*std::prev(first))) / 2;
    const double upper = last == codes_.end() ? z + 0.5 : (z + static_cast<double>(*last)) / 2;
    return {static_cast<std::size_t>(first - codes_.begin()), static_cast<std::size_t>(last - codes_.begin()),
            lower, upper};
  }
  std::size_t index(double share) const {
    return std::min(codes_.size() - 1, static_cast<std::size_t>(share * size()));
  }
  double size() const { return static_cast<double>(codes_.size()); }

  std::vector<float> codes_;
};

}  // namespace

// Of a curve with its matches and the prior.
struct ResponseEstimator::Agreement : CurveSquares {
  double match_misfit = 0, prior_misfit = 0;  // -2 ln of likelihood and prior of g

  using CurveSquares::CurveSquares;
};

struct ResponseEstimator::Curve {
  Vector g;
  Matrix precision;  // of g, given the matches, the prior and what the channels share
};

struct ResponseEstimator::Fit {
  std::array<Curve, 3> curves;
  Vector shared;  // noise, and ln of true over stated exposure by exposure_keys()
  std::optional<NoiseModel> seen;

  SensorNoise noise() const { return {shared[kFullWell], shared[kReadNoise]}; }
};

float ExposureCorrections::corrected(float exposure) const {
  const auto found = log_ratios_.find(key(exposure));
  return found == log_ratios_.end() ? exposure : exposure * static_cast<float>(std::exp(found->second));
}

int ExposureCorrections::key(float exposure) {
  return static_cast<int>(std::lround(std::log2(exposure) * 64));
}

// Of a stream that goes on.
void ResponseEstimator::keep_newest(std::vector<Match>& matches) {
  constexpr std::size_t kMost = 25 * std::size_t{kQuantiles};
  if (matches.size() > kMost)
    matches.erase(matches.begin(), matches.end() - static_cast<std::ptrdiff_t>(kMost));
}

bool ResponseEstimator::add_pair(const ExposedFrame& a, const ExposedFrame& b, SceneCuts cuts) {
  constexpr double kMinRatio = 1.15;       // of exposures: below it a pair does not constrain the curve
  constexpr double kSameSceneRank = 0.35;  // a cut is near 0; a fast pan of a textured scene stays above .6
  constexpr double kDarkShare = 0.0005;    // of the pixels
  constexpr double kBelowBlack = 0.1;      // of the pixels, at most: by noise and compression
  const ExposedFrame& shorter = a.exposure <= b.exposure ? a : b;
  const ExposedFrame& longer = &shorter == &a ? b : a;
  if (longer.exposure < static_cast<float>(kMinRatio) * shorter.exposure) return false;
  if (((a.facts.flags | b.facts.flags) & (kFrameExposureUnproved | kFrameDamaged)) != 0) return false;
  if (cuts == SceneCuts::Possible && rank_correlation(thumbnail(a), thumbnail(b)) < kSameSceneRank)
    return false;

  const bool shortest = pairs_ == 0 || shorter.exposure < 0.9f * shortest_;
  if (shortest) shortest_ = shorter.exposure;
  const std::pair key{ExposureCorrections::key(shorter.exposure), ExposureCorrections::key(longer.exposure)};
  std::vector<float> scratch;
  for (std::size_t c = 0; c < 3; ++c) {
    const Ranking dark(shorter, static_cast<int>(c), scratch), light(longer, static_cast<int>(c), scratch);
    if (shorter.exposure < 1.1f * shortest_) {
      const float darkest = dark.quantile(kDarkShare), most = dark.quantile(kBelowBlack);
      darkest_[c] = shortest ? darkest : std::min(darkest_[c], darkest);
      most_black_[c] = shortest ? most : std::min(most_black_[c], most);
    }
    Matches& matches = matches_[c][key];
    matches.log_ratio = (key.first - key.second) / 64.0 * std::log(2.0);
    for (int q = 1; q < kQuantiles; ++q) {
      const auto [code, share] = dark.boundary_near(static_cast<double>(q) / kQuantiles);
      if (share <= kDarkShare || share >= 1 - kDarkShare) continue;
      const double other = light.code_at(share);
      if (other >= code) matches.codes.push_back({static_cast<float>(code), static_cast<float>(other)});
    }
  }
  for (auto& channel : matches_) keep_newest(channel[key].codes);
  ++pairs_;
  return true;
}

// The black level under which a channel's matches agree best, exposures as stated. A pedestal is the
// exception: it must explain the matches better by a penalty, and by two where it is above the darkest
// pixels. The prior counts half below these, because it takes a dark scene under an unusual curve for a
// pedestal under a usual one, and does not argue for a level above them.
float ResponseEstimator::find_black_level(std::size_t channel, const NoiseModel& noise) const {
  constexpr double kPenalty = 10, kPriorShare = 0.5;
  const float darkest = std::min(darkest_[channel], kMaxBlackLevel);
  const float most = std::min(most_black_[channel], kMaxBlackLevel);
  double usual = std::numeric_limits<double>::max();  // the prior's misfit at levels that are not above
  const auto misfit = [&](float level) {
    const Agreement agreed = agreement_at(level, channel, noise);
    const bool above = level > darkest;
    if (!above) usual = std::min(usual, agreed.prior_misfit);
    return agreed.match_misfit +
           kPriorShare * (above ? std::max(usual, agreed.prior_misfit) : agreed.prior_misfit) +
           kPenalty * ((level > 0 ? 1 : 0) + (above ? 1 : 0));
  };
  std::vector<float> levels{0};
  const float third = (most - darkest) / 3;
  for (const float level : {darkest / 2, darkest, darkest + third, most - third, most})
    if (level >= levels.back() + 1) levels.push_back(level);
  if (levels.size() == 1) return 0;
  std::vector<double> misfits;
  misfits.reserve(levels.size());
  for (const float level : levels) misfits.push_back(misfit(level));

  const auto least =
      static_cast<std::size_t>(std::min_element(misfits.begin(), misfits.end()) - misfits.begin());
  float best = levels[least];
  if (least == 0) return best;
  double smallest = misfits[least];
  for (const std::size_t beside : {least - 1, least + 1}) {
    if (beside == levels.size()) continue;
    const float between = (levels[least] + levels[beside]) / 2;
    if (const double m = misfit(between); m < smallest) smallest = m, best = between;
  }
  return best;
}

ResponseEstimate ResponseEstimator::estimate(const NoiseModel& noise, ResponseModel model) const {
  BlackLevel black;
  for (std::size_t c = 0; c < 3; ++c)
    black.set(c, stated_black_ ? (*stated_black_)[c] : find_black_level(c, noise));
  const std::vector<int> keys = exposure_keys();
  if (model == ResponseModel::Linear) return {Response::linear(), black, {}, {}};
  if (model == ResponseModel::Mean) return {prior_mean_response(), black, {}, {}};
  if (model == ResponseModel::Network) {
    std::array<Vector, 3> g;
    for (std::size_t c = 0; c < 3; ++c)
      g[c] = fit_curve_network(prior().mean, [&](const Vector& at, Matrix& A, Vector& b) {
        Agreement agreed(shared_count(keys));
        add_matches(c, black[c], {noise}, at, keys, Vector::Zero(agreed.d.size()), agreed);
        A = std::move(agreed.A), b = std::move(agreed.b);
      });
    return {Response(curves_of(g)), black, {}, {}};
  }
  const Fit fit = solve(black, noise);
  // The uncertainty of the fit: the posterior deviation of ln x against the middle code, where the gauge is
  // fixed.
  std::array<Response::Curve, 3> uncertainty;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vector variance =
        fit.curves[c].precision.llt().solve(Matrix::Identity(kKnots, kKnots)).diagonal().cwiseMax(0);
    for (int z = 0; z < kKnots; ++z)
      uncertainty[c][static_cast<std::size_t>(z) + 1] = static_cast<float>(std::sqrt(variance[z]));
    uncertainty[c][0] = uncertainty[c][1];
  }
  ExposureCorrections exposures;
  for (std::size_t k = 0; k < keys.size(); ++k)
    exposures.set(std::exp2(static_cast<float>(keys[k]) / 64),
                  fit.shared[kExposures + static_cast<Eigen::Index>(k)]);
  const auto& [red, green, blue] = fit.curves;
  return {Response(curves_of({red.g, green.g, blue.g}), uncertainty), black, exposures, fit.seen};
}

std::vector<int> ResponseEstimator::exposure_keys() const {
  std::vector<int> keys;
  for (const auto& [pair, matches] : matches_[0]) keys.push_back(pair.first), keys.push_back(pair.second);
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

void ResponseEstimator::add_matches(std::size_t channel, float black_level, const MatchNoise& noise,
                                    const Vector& g, const std::vector<int>& keys, const Vector& shared,
                                    Agreement& agreed) const {
  // ln x: motion between the frames moves the quantiles, and so does compression
  const double match_sigma = noise.is_own ? 0.03 : 0.06;
  constexpr double kCauchy2 = 4;               // squared scale of the robust weight, in sigmas
  constexpr double kMatchWeight = 0.2;         // because quantiles are not independent
  constexpr double kWidened = 2;               // how far noise that widens a histogram moves its quantiles
  constexpr double kMaxWeightPerRatio = 1000;  // matches of one exposure ratio count as at most this many
  const auto [first, last] = clip_policy::kResponseMatch;
  const float stretch = kMaxCode / (kMaxCode - black_level);
  const double top = g[250];
  const auto variance = [&](const Knots& k) {
    const double slope = k.slope(g), x = std::exp(k.of(g) - top);
    const double relative =
        static_cast<double>(noise.model.exposure_variance(static_cast<float>(x))) / (x * x);
    return slope * slope / 12 + 0.5 * relative + (noise.is_own ? kWidened * relative * relative : 0);
  };

  for (const auto& [key, matches] : matches_[channel]) {
    if (matches.codes.empty()) continue;
    const auto place = [&](int k) {
      return kExposures + (std::lower_bound(keys.begin(), keys.end(), k) - keys.begin());
    };
    const Eigen::Index shorter = place(key.first), longer = place(key.second);
    const double log_ratio = matches.log_ratio + shared[shorter] - shared[longer];
    const double scale =
        kMatchWeight * std::min(1.0, kMaxWeightPerRatio / static_cast<double>(matches.codes.size()));
    double sum = 0, used = 0, usable = 0;
    for (const Match& match : matches.codes) {
      const float z1 = (match.z1 - black_level) * stretch, z2 = (match.z2 - black_level) * stretch;
      usable += match.z1 >= first && match.z2 <= last ? 1 : 0;
      if (z1 < first || z2 > last) continue;
      const Knots k1(static_cast<double>(z1)), k2(static_cast<double>(z2));
      const double r = k1.of(g) - k2.of(g) - log_ratio;
      const double s2 = match_sigma * match_sigma + variance(k1) + variance(k2);
      const double w = scale / s2 / (1 + r * r / (s2 * kCauchy2));
      sum += scale * kCauchy2 * std::log1p(r * r / (s2 * kCauchy2));
      used += 1;
      const std::array<Term, 4> of_curve{Term{k1.lo, 1 - k1.fraction},
                                         {k1.lo + 1, k1.fraction},
                                         {k2.lo, k2.fraction - 1},
                                         {k2.lo + 1, -k2.fraction}};
      const std::array<Term, 2> of_exposures{Term{shorter, -1}, {longer, 1}};
      agreed.add(w, matches.log_ratio, of_curve, of_exposures);
    }
    // matches that a higher black level drops count like the mean of the others, so that dropping gives no
    // advantage
    if (used > 0) agreed.match_misfit += sum * std::max(used, usable) / used;
  }
}

// Of a channel's curve with its matches and the prior.
ResponseEstimator::Agreement ResponseEstimator::agreement(std::size_t channel, float black_level,
                                                          const MatchNoise& noise, const Vector& g,
                                                          const std::vector<int>& keys,
                                                          const Vector& shared) const {
  const Prior& p = prior();
  Agreement agreed(shared_count(keys));
  agreed.A = p.precision, agreed.b = p.precision * p.mean;
  agreed.A(kGaugeKnot, kGaugeKnot) += 1e4;
  add_matches(channel, black_level, noise, g, keys, shared, agreed);
  const Vector d = g - p.mean;
  agreed.prior_misfit = d.dot(p.precision * d);
  return agreed;
}

// Of the curve that agrees best at this black level, exposures as stated.
ResponseEstimator::Agreement ResponseEstimator::agreement_at(float black_level, std::size_t channel,
                                                             const NoiseModel& noise) const {
  const std::vector<int> keys = exposure_keys();
  const Vector as_stated = Vector::Zero(shared_count(keys));
  Vector g = prior().mean;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Agreement agreed = agreement(channel, black_level, {noise}, g, keys, as_stated);
    g = agreed.A.llt().solve(agreed.b);
    make_monotone(g);
  }
  return agreement(channel, black_level, {noise}, g, keys, as_stated);
}

// Curves and what they share together: each channel's curve is eliminated from the equations of the shared.
ResponseEstimator::Fit ResponseEstimator::solve(const BlackLevel& black_level,
                                                const NoiseModel& noise) const {
  constexpr int kIterationsWithNoise = 12;  // it may lead far from the mean of real cameras
  const std::vector<int> keys = exposure_keys();
  const std::array<std::vector<NoiseLevel>, 3> levels = noise_levels_.levels();
  const bool shows_noise =
      std::any_of(levels.begin(), levels.end(), [](const auto& channel) { return !channel.empty(); });
  const Matrix shared_precision = precision_of_shared(keys);
  Fit fit{{}, Vector::Zero(shared_precision.rows()), {}};
  for (Curve& curve : fit.curves) curve = {prior().mean, {}};
  for (int iteration = 0; iteration < (shows_noise ? kIterationsWithNoise : kIterations); ++iteration) {
    Matrix Q = shared_precision;
    Vector q = Vector::Zero(Q.rows());
    std::array<Vector, 3> alone;  // curves, and their change with the shared
    std::array<Matrix, 3> change;
    for (std::size_t c = 0; c < 3; ++c) {
      Curve& curve = fit.curves[c];
      const MatchNoise of_matches{fit.seen.value_or(noise), fit.seen.has_value()};
      Agreement agreed = agreement(c, black_level[c], of_matches, curve.g, keys, fit.shared);
      add_noise_evidence(levels[c], black_level[c], curve.g, fit.noise(), kFullWell, agreed);
      const Eigen::LLT<Matrix> factor(agreed.A);
      alone[c] = factor.solve(agreed.b), change[c] = factor.solve(agreed.B);
      Q += agreed.C - agreed.B.transpose() * change[c];
      q += agreed.d - change[c].transpose() * agreed.b;
      curve.precision = std::move(agreed.A);
    }
    fit.shared = Q.ldlt().solve(q);
    for (std::size_t c = 0; c < 3; ++c) {
      Vector& g = fit.curves[c].g;
      g = alone[c] - change[c] * fit.shared;
      make_monotone(g);
    }
    if (shows_noise) fit.seen = noise_model(fit.noise(), noise.code_step);
  }
  return fit;
}

Response prior_mean_response() {
  const Vector& mean = prior().mean;
  return Response(curves_of({mean, mean, mean}));
}

}  // namespace hdrcam
