// Equations of a channel's curve g = ln x at the codes 1..255, and of what the channels share, as a sum of
// squares that many measurements add to. Value types, reentrant.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

namespace hdrcam {

constexpr int kKnots = 255;  // g(z) at the codes 1..255

// A code between two knots of g.
struct Knots {
  int lo;
  double fraction;
  explicit Knots(double code) {
    const double position = std::clamp(code - 1, 0.0, kKnots - 1.0);
    lo = std::min(static_cast<int>(position), kKnots - 2);
    fraction = position - lo;
  }
  double of(const Eigen::VectorXd& g) const { return g[lo] + fraction * (g[lo + 1] - g[lo]); }
  double slope(const Eigen::VectorXd& g) const {  // per code, over three codes
    const int z = fraction < 0.5 ? lo : lo + 1, a = std::max(0, z - 1), b = std::min(kKnots - 1, z + 1);
    return (g[b] - g[a]) / (b - a);
  }
};

// Raises what does not rise from code to code, which light does.
inline void make_rising(Eigen::VectorXd& g) {
  constexpr double kLeastRise = 1e-4;  // ln x
  for (Eigen::Index z = 1; z < g.size(); ++z) g[z] = std::max(g[z], g[z - 1] + kLeastRise);
}

// An unknown of a linear equation, and its factor.
struct Term {
  Eigen::Index at;
  double factor;
};

// The sum over equations of weight (J g + K e - target)^2, without a constant:
// g'A g + 2 g'B e + e'C e - 2 b'g - 2 d'e, with what the channels share, e.
struct CurveSquares {
  Eigen::MatrixXd A, B, C;
  Eigen::VectorXd b, d;

  explicit CurveSquares(Eigen::Index shared)
      : A(Eigen::MatrixXd::Zero(kKnots, kKnots)),
        B(Eigen::MatrixXd::Zero(kKnots, shared)),
        C(Eigen::MatrixXd::Zero(shared, shared)),
        b(Eigen::VectorXd::Zero(kKnots)),
        d(Eigen::VectorXd::Zero(shared)) {}

  void add(double weight, double target, std::span<const Term> of_curve, std::span<const Term> of_shared) {
    for (const Term& p : of_curve) {
      b[p.at] += weight * target * p.factor;
      for (const Term& q : of_curve) A(p.at, q.at) += weight * p.factor * q.factor;
      for (const Term& q : of_shared) B(p.at, q.at) += weight * p.factor * q.factor;
    }
    for (const Term& p : of_shared) {
      d[p.at] += weight * target * p.factor;
      for (const Term& q : of_shared) C(p.at, q.at) += weight * p.factor * q.factor;
    }
  }

  // What an equation has of weight beyond what it tells of g: a bound holds g, but says not how far beyond it
  // g is.
  struct Hold {
    double weight;
    std::array<Term, 4> of_curve;
  };
  std::vector<Hold> holds;

  // The precision of g: A without what only holds it.
  Eigen::MatrixXd take_precision() && {
    for (const auto& [weight, of_curve] : holds)
      for (const Term& p : of_curve)
        for (const Term& q : of_curve) A(p.at, q.at) -= weight * p.factor * q.factor;
    return std::move(A);
  }
};

}  // namespace hdrcam
