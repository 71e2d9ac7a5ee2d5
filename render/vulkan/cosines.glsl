// The 8x8 cosine transform of a tile in registers, eight pixels or frequencies of a row as two vectors: row i is
// tile[2 i], tile[2 i + 1]. Even frequencies see the sums of mirrored pixels, odd ones their differences. Every
// index is known once the loops are unrolled: an array that is indexed at run time lives in memory.
#extension GL_EXT_control_flow_attributes : require

// Column k: cosines of frequency 2 k, and 2 k + 1, at pixels 0..3.
const mat4 kEven = mat4(kCos4, kCos4, kCos4, kCos4, kCos2, kCos6, -kCos6, -kCos2,
                        kCos4, -kCos4, -kCos4, kCos4, kCos6, -kCos2, kCos2, -kCos6);
const mat4 kOdd = mat4(kCos1, kCos3, kCos5, kCos7, kCos3, -kCos7, -kCos1, -kCos5,
                       kCos5, -kCos1, kCos7, kCos3, kCos7, -kCos5, kCos3, -kCos1);

void forward_rows(inout vec4 tile[16]) {
  [[unroll]] for (int i = 0; i < 8; ++i) {
    const vec4 mirrored = tile[2 * i + 1].wzyx;
    const vec4 even = (tile[2 * i] + mirrored) * kEven, odd = (tile[2 * i] - mirrored) * kOdd;
    tile[2 * i] = vec4(even.x, odd.x, even.y, odd.y);
    tile[2 * i + 1] = vec4(even.z, odd.z, even.w, odd.w);
  }
}

void backward_rows(inout vec4 tile[16]) {
  [[unroll]] for (int i = 0; i < 8; ++i) {
    const vec4 even = kEven * vec4(tile[2 * i].xz, tile[2 * i + 1].xz);
    const vec4 odd = kOdd * vec4(tile[2 * i].yw, tile[2 * i + 1].yw);
    tile[2 * i] = even + odd;
    tile[2 * i + 1] = (even - odd).wzyx;
  }
}

void forward_columns(inout vec4 tile[16]) {
  [[unroll]] for (int half_row = 0; half_row < 2; ++half_row) {
    mat4 sums, differences;  // a column each
    [[unroll]] for (int i = 0; i < 4; ++i) {
      const vec4 a = tile[2 * i + half_row], b = tile[2 * (7 - i) + half_row];
      sums[i] = a + b, differences[i] = a - b;
    }
    [[unroll]] for (int k = 0; k < 4; ++k) {
      tile[4 * k + half_row] = sums * kEven[k];
      tile[4 * k + 2 + half_row] = differences * kOdd[k];
    }
  }
}

void backward_columns(inout vec4 tile[16]) {
  [[unroll]] for (int half_row = 0; half_row < 2; ++half_row) {
    mat4 even, odd;  // coefficients, a column each
    [[unroll]] for (int k = 0; k < 4; ++k) even[k] = tile[4 * k + half_row], odd[k] = tile[4 * k + 2 + half_row];
    const mat4 sums = even * transpose(kEven), differences = odd * transpose(kOdd);
    [[unroll]] for (int i = 0; i < 4; ++i) {
      tile[2 * i + half_row] = sums[i] + differences[i];
      tile[2 * (7 - i) + half_row] = sums[i] - differences[i];
    }
  }
}
