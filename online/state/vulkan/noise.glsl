// Variance of a sample of a pixel of this radiance; the includer declares `tables` and `exposure`.
float noise_variance(int channel, float radiance) {
  const float root = sqrt(clamp(radiance * exposure, 0.0, 1.0)) * kSegments;
  return tables[3 * kCodes + channel * kRoots + int(root)];
}
