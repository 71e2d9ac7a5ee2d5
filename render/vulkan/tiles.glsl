// Tiles of 8x8 pixels on the grid of render/shrinkage.h; the last of a line ends with the picture. Includers
// declare `rows`, `cols`, `tile_rows`, `tile_cols`, `line_step` and `shift`.
#include "render/shrinkage_constants.h"

const int kTile = kShrinkageTile, kStep = kShrinkageStep;

int at(int channel, int y, int x) { return (channel * rows + y) * cols + x; }
int line_of(int i) { return min(i * line_step, rows - kTile); }
int shift_of(int i) { return i < tile_rows - 1 ? i % 2 * shift : 0; }
int column_of(int i, int j) { return min(j * kStep + shift_of(i), cols - kTile); }
int tiles_in_line(int i) { return (max(0, cols - kTile - shift_of(i)) + kStep - 1) / kStep + 1; }
bool in_step(int i, int j) { return column_of(i, j) == j * kStep + shift_of(i); }
int tile_at(int channel, int i, int j) { return (channel * tile_rows + i) * tile_cols + j; }

const vec3 kOpponent[3] = {vec3(kOfLuminance), vec3(-kOfRedBlue, 0, kOfRedBlue), vec3(kOfBoth, -kOfGreen, kOfBoth)};
