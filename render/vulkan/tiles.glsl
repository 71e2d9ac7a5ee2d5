// Tiles of 8x8 pixels on the grid of render/shrinkage.h; the last of a line ends with the picture. Includers
// declare `rows`, `cols`, `tile_rows`, `tile_cols`, `line_step` and `shift`. A tile is its weight and its 64
// values times that: kTileFloats, side by side.
const int kTile = 8, kStep = 4, kTileFloats = 65;

int at(int channel, int y, int x) { return (channel * rows + y) * cols + x; }
int line_of(int i) { return min(i * line_step, rows - kTile); }
int shift_of(int i) { return i < tile_rows - 1 ? i % 2 * shift : 0; }
int column_of(int i, int j) { return min(j * kStep + shift_of(i), cols - kTile); }
int tiles_in_line(int i) { return (max(0, cols - kTile - shift_of(i)) + kStep - 1) / kStep + 1; }
int tile_at(int channel, int i, int j) { return ((channel * tile_rows + i) * tile_cols + j) * kTileFloats; }

// Orthonormal: luminance, red - blue, green against both.
const vec3 kOpponent[3] = {vec3(0.57735), vec3(-0.70711, 0, 0.70711), vec3(0.40825, -0.81650, 0.40825)};
