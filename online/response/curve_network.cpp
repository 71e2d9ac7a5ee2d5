#include "online/response/curve_network.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "online/response/curve_squares.h"

namespace hdrcam {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr int kNeurons = 12;
constexpr int kParameters = 3 * kNeurons + 1;  // a, b, c of each neuron; d

// About -1..1 over the codes.
double input_of(Eigen::Index knot) {
  return 1 + 2 * std::log((static_cast<double>(knot) + 1) / 255) / std::log(255.0);
}

Vector starting_parameters() {
  Vector parameters = Vector::Zero(kParameters);
  for (int j = 0; j < kNeurons; ++j) {
    parameters[3 * j + 1] = 2;                             // b
    parameters[3 * j + 2] = 2 - 4 * (j + 0.5) / kNeurons;  // c: bends all over the codes
  }
  return parameters;
}

// The curve, and its Jacobian if wanted.
Vector curve_of(const Vector& parameters, Eigen::Index knots, Matrix* jacobian) {
  Vector g = Vector::Constant(knots, parameters[kParameters - 1]);
  if (jacobian != nullptr) jacobian->setOnes(knots, kParameters);
  for (Eigen::Index z = 0; z < knots; ++z)
    for (int j = 0; j < kNeurons; ++j) {
      const double u = input_of(z), a = parameters[3 * j];
      const double bent = std::tanh(parameters[3 * j + 1] * u + parameters[3 * j + 2]);
      g[z] += a * bent;
      if (jacobian == nullptr) continue;
      const double slope = a * (1 - bent * bent);
      (*jacobian)(z, 3 * j) = bent, (*jacobian)(z, 3 * j + 1) = slope * u, (*jacobian)(z, 3 * j + 2) = slope;
    }
  return g;
}

// One damped step after another towards min (g - g*)' A (g - g*), A g* = b; a step that does not lower it is
// taken back.
void descend(const Matrix& A, const Vector& b, Eigen::Index knots, Vector& parameters) {
  constexpr int kSteps = 12;
  double damping = 1e-2;
  const auto misfit = [&](const Vector& g) { return 0.5 * g.dot(A * g) - b.dot(g); };
  Matrix jacobian;
  for (int step = 0; step < kSteps; ++step) {
    const Vector g = curve_of(parameters, knots, &jacobian);
    Matrix normal = jacobian.transpose() * A * jacobian;
    normal.diagonal() += damping * (normal.diagonal().array() + 1e-6).matrix();
    const Vector trial = parameters + normal.llt().solve(jacobian.transpose() * (b - A * g));
    const bool better = trial.allFinite() && misfit(curve_of(trial, knots, nullptr)) < misfit(g);
    if (better) parameters = trial;
    damping = std::clamp(better ? damping / 3 : damping * 5, 1e-6, 1e6);
  }
}

}  // namespace

Vector fit_curve_network(const Vector& start, const CurveEquations& equations) {
  constexpr int kRounds = 8;            // of the robust weights
  constexpr double kGaugeWeight = 1e2;  // a common factor is not observable: the level of the start is kept
  const Eigen::Index knots = start.size();
  Vector parameters = starting_parameters();
  descend(Matrix::Identity(knots, knots), start, knots, parameters);
  Vector g = curve_of(parameters, knots, nullptr);
  Matrix A;
  Vector b;
  for (int round = 0; round < kRounds; ++round) {
    equations(g, A, b);
    A(knots / 2, knots / 2) += kGaugeWeight;
    b[knots / 2] += kGaugeWeight * start[knots / 2];
    descend(A, b, knots, parameters);
    g = curve_of(parameters, knots, nullptr);
    make_rising(g);
  }
  return g;
}

}  // namespace hdrcam
