// By the radiance of a pixel; the includer declares `tables` and `exposure`.
float by_radiance(int table, float radiance) {
  const float root = sqrt(clamp(radiance * exposure, 0.0, 1.0)) * kSegments;
  return tables[3 * kCodes + table * kRoots + int(root)];
}
// Variance of a sample of a pixel of this radiance.
float noise_variance(int channel, float radiance) { return by_radiance(channel, radiance); }
// ExposureTables::hidden_texture()
float hidden_texture(int channel, float radiance, float contrast) {
  const float most = by_radiance(3 + channel, radiance);
  return contrast * most / (contrast + most + kTiny);
}
