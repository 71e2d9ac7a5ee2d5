// A picture drawn as a mesh into another picture: the pixel centres of the source are the vertices, moved to
// where the target sees them. Where neighbours move apart the mesh is torn, not stretched: what lies between
// them is a hole. Where surfaces overlap the higher rank wins. The answer is, for each target pixel, the
// place in the source that it shows, so that the source is interpolated only once. Positions in pixels,
// centres at +0.5. Thread-bound; the answer does not depend on the number of threads.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// Where the source's vertices land; a ring of one pixel is added around the source, half a pixel wide.
struct MeshVertices {
  Image<float> place;    // [x y, rows + 2, cols + 2] in the target
  Image<float> inverse;  // [1, rows + 2, cols + 2] inverse depth seen from the target; <= 0: not drawn
  Image<float> rank;     // [1, rows + 2, cols + 2] the highest wins
  Image<float> size;     // [1, rows + 2, cols + 2] expected distance between neighbours in the target, pixels

  void reshape(int rows, int cols);
  int rows() const { return inverse.rows() - 2; }
  int cols() const { return inverse.cols() - 2; }
  // The source place of a vertex: a pixel centre, or the border for the ring.
  static float source(int vertex, int size);
};

// What the target shows of the source.
struct MeshAnswer {
  Image<float> source;   // [x y, rows, cols] place in the source
  Image<float> inverse;  // [1, rows, cols] inverse depth; 0: a hole
  Image<float> rank;     // [1, rows, cols]
  Image<float> size;     // [1, rows, cols] of a source pixel, pixels of the target; unset in holes
};

// rows, cols: of the target.
void draw_mesh(const MeshVertices& vertices, int rows, int cols, WorkerPool& pool, MeshAnswer& answer);

}  // namespace hdrcam
