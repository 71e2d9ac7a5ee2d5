// The dense flow on the processor, on kernels of this program's own (flow_kernels.h). The work is cut into
// strips that do not depend on the number of threads, so neither does the answer. Thread-bound.
#pragma once

#include <array>
#include <vector>

#include "hal/core/worker_pool.h"
#include "online/priors/motion/dense_flow.h"
#include "online/priors/motion/flow_effort.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/priors/motion/refinement_kernels.h"

namespace hdrcam {

class CpuFlow final : public DenseFlow {
 public:
  explicit CpuFlow(WorkerPool& pool) : pool_(pool), kernels_(flow_kernels()) {}

  void compute(FlowQuality quality, const FlowRequest& request) override;

 private:
  struct Level {
    Image<float> planes;  // [gray dx dy, rows, cols] with a border; borrowed during a call
    FlowPicture picture{};
  };
  using Pyramid = std::vector<Level>;
  struct Direction {
    const Pyramid *from, *to;
    FlowGuess start;
    Image<float>* answer;
    Image<float> patches, starts;        // [dx dy, rows, cols] of the patches
    Image<float> far, agreed, far_back;  // the same: what was found far away, what of it is believed, and
                                         // what the other direction found
    // borrowed during a call: [dx dy, ...], [1, ...] and the refinement's room, of the scale
    Image<float> flow, weight, larger;
    std::array<Image<float>, kRefinementPieces> room;
    std::vector<float> line;  // of enlarge()
    PatchSearch search{};     // of the scale
  };
  void ask(const FlowRequest& request);
  static Level& level_of(Pyramid& pyramid, int scale);
  void build(const Image<float>& picture, int finest, int coarsest, Pyramid& pyramid);
  void match(int scale, const FlowScales& scales, const FlowEffort& effort);
  void search();
  void search_far();
  void prepare(Direction& direction, int scale, int coarsest, const FlowEffort& effort);
  void refine(Direction& direction, int scale, const FlowEffort& effort);
  void enlarge_answers(int finest, int rows, int cols);
  static void enlarge(const Image<float>& flow, std::vector<float>& line, Image<float>& answer);

  WorkerPool& pool_;
  const FlowKernels& kernels_;
  std::array<Pyramid, 2> pyramids_;
  std::array<Direction, 2> directions_{};
};

}  // namespace hdrcam
