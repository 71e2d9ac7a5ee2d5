// Depth of what moves. No baseline measures it: the displacement of a dynamic point is its own motion and the
// camera's. What is known of it is an order: what moves and covers a surface is nearer than that surface. So
// each dynamic region (connected, seen to move against the static scene) is one surface, parallel to the
// picture: where what is below it is nearer than what is around it, it stands there, at that depth; else it
// is at half the distance of what is around it. Both are guesses, and weighted as such; smooth in time, as
// regions are followed along the flow. Thread-bound; allocates nothing per frame.
#pragma once

#include <vector>

#include "online/priors/depth/multi_view_depth.h"

namespace hdrcam {

struct DynamicDepthOptions {
  float nearer = 2;  // 0..10: inverse depth of a dynamic region over that of what is around it; 0: no guess
  float weight = 0.735f;  // of a guess: sigma 60 percent of the inverse depth
  float keep = 0.7f;      // of the last frame's guess, in ln, where the region was seen then
  int least_points = 12;  // of the grid; smaller regions are noise of the flow
  float standing = 1.1f;  // inverse depth below a region over that around it, from which on it stands there
};

class DynamicDepth final : public DepthPrior {
 public:
  DynamicDepth(const DepthOptions& depth, const DynamicDepthOptions& options, const Intrinsics& lens,
               int rows, int cols, WorkerPool& pool);

  // The measured depth, and the guesses where something moves.
  const DepthMap& estimate(const SeenFrame& seen, const CameraPose& pose) override;

  // The same of any measured map. dynamic: [1, rows, cols] of the map's grid, 1 where a point was seen to
  // move against the static scene; to_previous: [dx dy, rows, cols] of the picture, px, empty for the first.
  const DepthMap& complete(const DepthMap& measured, const Image<float>& dynamic,
                           const FlowField& to_previous);

 private:
  struct Region {
    int points = 0, top = 0, bottom = 0;  // rows of the grid
    float inverse_depth = 0;
  };

  void mark_moving(const DepthMap& measured, const Image<float>& dynamic);
  void find_regions();
  void grow(int y, int x, int label);
  void measure_reach();
  float around(int label, const DepthMap& measured);
  float below(int label, const DepthMap& measured);
  float last_guess(int label, const FlowField& to_previous);

  DynamicDepthOptions options_;
  MultiViewDepth measured_;
  DepthMap completed_;
  Image<float> guess_;           // [1, rows, cols] inverse depth of dynamic regions, 0 elsewhere
  Image<std::int32_t> label_;    // [1, rows, cols] region + 1; 0: static or unknown; -1: to be labelled
  Image<std::int32_t> nearest_;  // [1, rows, cols] sums of votes, then the label of the region near a point..
  Image<std::int32_t> reach_;    // ..and its distance, grid points
  std::vector<Region> regions_;
  std::vector<std::int32_t> waiting_;  // of a region that grows
  std::vector<float> values_;
};

}  // namespace hdrcam
