// Where what moves fast arrives. A motion is known at the pixels that it starts from, and needed at those
// that it leads to, where something else was before: a search begins there, and so does the path over a
// clipped frame. So pixels that move fast are thrown ahead, into cells; the fastest of a cell stays, because
// what is in front mostly moves faster. What is written there is a guess: pixels of the cell's rest do not
// move so.
#pragma once

#include <vector>

#include "hal/core/image.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {

// A pixel and its motion, pixels.
struct Mover {
  float x, y, u, v;
};

// The pixels of a motion [dx dy, rows, cols] that are faster than `least` pixels, one of four of them.
// holds(x, y): whether the motion is believed there.
template <class Holds>
void find_movers(const Image<float>& motion, float least, Holds&& holds, std::vector<Mover>& movers) {
  constexpr int kEvery = 2;
  movers.clear();
  for (int y = 0; y < motion.rows(); y += kEvery) {
    const float *u = motion.row(0, y), *v = motion.row(1, y);
    for (int x = 0; x < motion.cols(); x += kEvery)
      if (u[x] * u[x] + v[x] * v[x] >= least * least && holds(x, y))
        movers.push_back({static_cast<float>(x), static_cast<float>(y), u[x], v[x]});
  }
}

class Landing {
 public:
  Landing(int rows, int cols);  // of the picture

  // `kept` times the motion of the fastest pixel that is in each cell after `way` times its motion; of what
  // is beside a cell where nothing is.
  void throw_ahead(const std::vector<Mover>& movers, float way, float kept);
  // [dx dy, cells down, cells across] pixels; kNowhere where nothing comes
  const Image<float>& cells() const { return cells_; }

 private:
  Image<float> landed_, cells_;
};

}  // namespace hdrcam
