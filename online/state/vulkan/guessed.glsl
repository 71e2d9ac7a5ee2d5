// The variance of what is only guessed to be there: its own size. The twin is online/state/fusion_kernels.cpp.
float guessed(int channel, float radiance, float sample_) {
  const float least = 0.5 * (tables[channel * kCodes] + tables[channel * kCodes + 1]);  // half a code
  const float size = max(max(radiance, sample_), least);
  return size * size;
}
