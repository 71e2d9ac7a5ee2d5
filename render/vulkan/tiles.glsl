// Tiles of 8x8 pixels, 4 apart; the last of a line ends with the picture. Includers declare `rows`, `cols`,
// `tile_rows` and `tile_cols`. A tile is its weight and its 64 values times that: kTileFloats, side by side.
const int kTile = 8, kStep = 4, kTileFloats = 65;

int at(int channel, int y, int x) { return (channel * rows + y) * cols + x; }
int first_of(int tile, int pixels) { return min(tile * kStep, pixels - kTile); }
int tile_at(int channel, int i, int j) { return ((channel * tile_rows + i) * tile_cols + j) * kTileFloats; }

// Orthonormal: luminance, red - blue, green against both.
const vec3 kOpponent[3] = {vec3(0.57735), vec3(-0.70711, 0, 0.70711), vec3(0.40825, -0.81650, 0.40825)};
