// A response as a small network instead of free knots: g(z) = sum_j a_j tanh(b_j u + c_j) + d with u a
// logarithm of the code (HDR-NeRF's tone mapper, the "MLP CRF" of the paper's table of tone-mapping designs).
// It has no prior: where no match reaches, it extrapolates. For ablation; the product's curve is
// response_estimator.h. Reentrant.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace hdrcam {

// The normal equations A g = b of the matches, linear at a curve g: [codes 1..255] ln x.
using CurveEquations = std::function<void(const Eigen::VectorXd& g, Eigen::MatrixXd& A, Eigen::VectorXd& b)>;

// The network's curve that solves the equations best (Levenberg-Marquardt), rising. start: where it begins.
Eigen::VectorXd fit_curve_network(const Eigen::VectorXd& start, const CurveEquations& equations);

}  // namespace hdrcam
