// The losses of the fit by name, with their default weights; objective.h computes them. What only sets
// weights includes this table and not the losses. Plain values; reentrant.
#pragma once

#include <array>
#include <cstddef>

namespace hdrcam {

enum class LossTerm : std::size_t {
  Combined,
  Warped,
  Occlusion,
  Flow,
  Depth,
  Cycle,
  SpatialSmoothness,
  TemporalSmoothness,
  MinimalFlow,
  State,
  Consistency,
  BlendEntropy,
  Distortion,
  ResponseSmoothness,
};
constexpr std::size_t kLossTerms = static_cast<std::size_t>(LossTerm::ResponseSmoothness) + 1;

struct LossFact {
  const char* name;
  float weight;  // default; 0: the term is off
  const char* meaning;
};

// By LossTerm. Values 0..1 for the photometric terms, pixels for the flow terms.
extern const std::array<LossFact, kLossTerms> kLosses;

using LossWeights = std::array<float, kLossTerms>;
LossWeights default_loss_weights();

template <class T>
using LossValues = std::array<T, kLossTerms>;

}  // namespace hdrcam
