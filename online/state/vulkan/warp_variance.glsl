// Variance that a warp along a flow adds to a picture, per local contrast: misalignment and interpolation.
// After state.glsl.
float warp_variance(float u, float v, float misalignment2) {
  const float fx = u - floor(u), fy = v - floor(v);
  const float between = 2 * (fx * (1 - fx) + fy * (1 - fy));
  const float moving = min(1.0, sqrt(u * u + v * v));
  return misalignment2 * (kByMotion * moving + kByInterpolation * between);
}
