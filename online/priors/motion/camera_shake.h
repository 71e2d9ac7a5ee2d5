// How a picture as a whole has moved from where it was predicted: the shake of a camera, which no motion
// before tells. In a dark frame noise hides it from each patch (dense_flow.h), but not from all of them
// together.
//
//   minimise over d  sum over the state's edges  rho(frame(x - ratio p(x) - d) - state(x) - offset)
//
// from coarse to fine (Lucas and Kanade, IJCAI 1981; gradients of the state, which has less noise, as Baker
// and Matthews, IJCV 2004; rho of Cauchy, as wide as the differences themselves). Two halves of the picture,
// a chessboard, are asked apart: what they agree on is no noise. How far they are apart is measured by what
// edges tell: along an edge neither half knows. Thread-bound; no allocation after the first frame.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/between_pixels.h"

namespace hdrcam {

class CameraShake {
 public:
  CameraShake(int rows, int cols);

  // Pictures [1, rows, cols] of codes, the state as the frame's exposure records it. predicted: [dx dy, rows,
  // cols], whose `ratio` times is the motion from the frame's pixels to the state's, read at the state's.
  // Returns what that motion is more, the same for all pixels; zero where the halves do not agree.
  Offset measure(const Image<float>& frame, const Image<float>& state, const Image<float>& predicted,
                 float ratio, WorkerPool& pool);

 private:
  // Both pictures, halved `scale` times.
  struct Level {
    int scale = 0;
    Image<float> frame, state;
    bool is_compared() const;
  };
  // A pixel at an edge of the state: its code, its slope, and where it is predicted to be in the frame.
  struct EdgePixel {
    float code, slope_x, slope_y, x, y;
  };
  struct Told;
  struct Half {
    std::vector<EdgePixel> edges;  // of the level in progress
    std::vector<float> differences, sorted;
  };

  void shrink(const Image<float>& frame, const Image<float>& state);
  std::optional<Told> follow(int half, const Image<float>& predicted, float ratio);
  void find_edges(int half, const Level& level, const Image<float>& predicted, float ratio);
  static bool approach(const Level& level, Half& half, Told& told);

  const float farthest_px_;
  int square_px_ = 0;          // the side of the chessboard's squares
  std::vector<Level> levels_;  // from fine to coarse; the coarser ones are compared
  std::array<Half, 2> halves_;
};

}  // namespace hdrcam
