// What a pixel of each direction is solved with, after flow.glsl.
const int kDataPlanes = 3;    // dt, dx, dy: the pictures along the flow that is refined
const int kSystemPlanes = 6;  // a12, c1, c2, inverse_u, inverse_v, link
