// The curves of real cameras, as a Gaussian prior of g = ln x over the codes 1..255: mean and principal
// directions of 201 measured curves (dorf_prior.inc, made by make_dorf_prior.py), a smooth free part for
// other cameras, and a small independent part per code. Immutable, reentrant.
#pragma once

#include <Eigen/Core>

namespace hdrcam {

struct CurvePrior {
  Eigen::VectorXd mean;       // [codes 1..255] ln x, 0 at code 128
  Eigen::MatrixXd precision;  // [codes 1..255, codes 1..255] 1 / (ln x)^2
};

const CurvePrior& curve_prior();

// g of the largest code as the prior expects it of a curve with this g up to a code.
double expected_white(const Eigen::VectorXd& g, int code);

}  // namespace hdrcam
