// Dense optical flow between two pictures, both ways: inverse search of patches from coarse to fine (DIS,
// Kroeger et al., ECCV 2016), and at each scale a robust smoothing where the pictures allow it (Brox et al.,
// ECCV 2004), on this program's own kernels (flow_kernels.h). At one coarse scale what is not explained is
// looked for in a third of the picture: an object that moves farther than its own size. The work is cut into
// strips that do not depend on the number of threads, so neither does the answer. Thread-bound.
#pragma once

#include <array>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "online/priors/motion/flow_kernels.h"
#include "online/priors/motion/motion_prior.h"
#include "online/priors/motion/refinement_kernels.h"

namespace hdrcam {

// Where a search starts: what each pixel's motion may be.
struct FlowGuess {
  const Image<float>* vectors = nullptr;  // [dx dy, rows, cols] pixels; null: no guess
  float scale = 1;
  bool carried = false;  // the vectors are of the other picture's pixels: they are read where they lead
};

// Pictures [1, rows, cols] of codes, 0..255, and the vectors [dx dy, rows, cols], pixels, that lead from each
// pixel of the one to where it is in the other.
struct FlowRequest {
  const Image<float>*a, *b;
  Image<float>*a_to_b, *b_to_a;
  FlowGuess start_a_to_b = {}, start_b_to_a = {};
};

class DenseFlow {
 public:
  static constexpr int kMinSize = 16;  // pixels: a smaller picture has no flow to find, the answer is zero

  explicit DenseFlow(WorkerPool& pool) : pool_(pool), kernels_(flow_kernels()) {}

  void compute(FlowQuality quality, const FlowRequest& request);

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
  struct Effort;

  static Effort effort_of(FlowQuality quality);
  static Level& level_of(Pyramid& pyramid, int scale);
  void build(const Image<float>& picture, int finest, int coarsest, Pyramid& pyramid);
  void match(int scale, int coarsest, const Effort& effort);
  void search();
  void search_far();
  void prepare(Direction& direction, int scale, int coarsest, const Effort& effort);
  void refine(Direction& direction, int scale, const Effort& effort);
  static void enlarge(const Image<float>& flow, std::vector<float>& line, Image<float>& answer);

  WorkerPool& pool_;
  const FlowKernels& kernels_;
  std::array<Pyramid, 2> pyramids_;
  std::array<Direction, 2> directions_{};
};

}  // namespace hdrcam
