// Sums that do not depend on the order of their terms: whole numbers of a unit that suits the largest term of
// a level, in two words, because one has too few bits for gradients of a millionth of that. Each term adds its
// lower bits to one word and the rest, rounded down, to the other. With 2^count_bits samples, of which each adds
// at most eight times to an entry and weighs at most 1 in all, neither word overflows:
//   low word   2^(count_bits + 3) terms of at most 2^low_bits; low_bits = 28 - count_bits
//   high word  2^count_bits terms of at most 2^(term_bits - low_bits) + 8;
//              term_bits = 30 + low_bits - count_bits
// The unit is 2^-term_bits of a power of two above the largest term: 2^-34 of it for 4096 samples, 2^-24 for
// 131072. What is smaller counts as no gradient.
int low_bits(int count_bits) { return 28 - count_bits; }

float power_of_two(int exponent) { return uintBitsToFloat(uint(exponent + 127) << 23); }

// Of the power of two above a peak, not so small that units leave the range of floats.
int exponent_above(uint peak) { return max(int(peak >> 23) - 126, -70); }
float units_per_one(uint peak, int count_bits) {
  return power_of_two(30 + low_bits(count_bits) - count_bits - exponent_above(peak));
}
float unit_of(uint peak, int count_bits) {
  return power_of_two(exponent_above(peak) - 30 - low_bits(count_bits) + count_bits);
}

struct Words {
  uint high, low;
};
Words words_of(float units, int bits) {
  const float high = floor(units * power_of_two(-bits));
  return Words(uint(int(high)), uint(units - high * power_of_two(bits) + 0.5));
}
float units_of(uint high, uint low, int bits) {
  const int carried = int(high) + int(low >> bits);
  return float(carried) * power_of_two(bits) + float(low & ((1u << bits) - 1u));
}
