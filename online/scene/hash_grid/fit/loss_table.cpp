#include "online/scene/hash_grid/fit/loss_table.h"

namespace hdrcam {

constinit const std::array<LossFact, kLossTerms> kLosses = {{
    {"combined", 1.f, "difference between the rendered picture and the codes, through the response"},
    {"warped", 0.5f, "difference between the picture warped from a neighbour and the codes"},
    {"occlusion", 0.1f, "how far a ray is marked as occluded"},
    {"flow", 0.02f, "distance between the rendered scene flow and the flow prior, pixels"},
    {"depth", 0.1f, "difference between the rendered inverse depth and the depth prior, where there is one"},
    {"cycle", 0.02f, "distance left after scene flow there and back, pixels"},
    {"spatial", 0.002f, "difference in scene flow between neighbouring samples of a ray"},
    {"temporal", 0.002f, "acceleration: forward plus backward scene flow"},
    {"minimal", 0.001f, "distance between the scene flow and the flow prior that it starts from"},
    {"state", 0.2f, "difference in log radiance between picture and state, where the state is certain"},
    {"consistency", 0.2f,
     "difference in log radiance between neighbouring frames, where the flow is certain"},
    {"entropy", 1e-3f, "entropy of the split of a ray into static and dynamic"},
    {"distortion", 0.f, "spread of the weights along a ray"},
    {"response", 1e-3f, "second differences of the response"},
}};

LossWeights default_loss_weights() {
  LossWeights weights{};
  for (std::size_t i = 0; i < kLosses.size(); ++i) weights[i] = kLosses[i].weight;
  return weights;
}

}  // namespace hdrcam
