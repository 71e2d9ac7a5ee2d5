// Interpolation in planes of `source`, which the includer declares, at a place from split_position().
float linear_at(int channel, ivec4 place) {
  const int y0 = clamp(place.y, 0, rows - 1), y1 = clamp(place.y + 1, 0, rows - 1);
  const int x0 = clamp(place.x, 0, cols - 1), x1 = clamp(place.x + 1, 0, cols - 1);
  const float fx = float(place.z) / kSubpixels, fy = float(place.w) / kSubpixels;
  const float a = source[at(channel, y0, x0)], b = source[at(channel, y0, x1)];
  const float c = source[at(channel, y1, x0)], d = source[at(channel, y1, x1)];
  const float top = a + fx * (b - a), bottom = c + fx * (d - c);
  return top + fy * (bottom - top);
}

// Within `limit` of the linear value, up and down, where the limit is above 0.
float cubic_at(int channel, ivec4 place, float limit) {
  if ((place.z | place.w) == 0)
    return source[at(channel, clamp(place.y, 0, rows - 1), clamp(place.x, 0, cols - 1))];
  const vec4 wx = cubic_weights(float(place.z) / kSubpixels), wy = cubic_weights(float(place.w) / kSubpixels);
  float value = 0;
  for (int j = 0; j < 4; ++j) {
    const int y = clamp(place.y + j - 1, 0, rows - 1);
    vec4 p;
    for (int i = 0; i < 4; ++i) p[i] = source[at(channel, y, clamp(place.x + i - 1, 0, cols - 1))];
    value += wy[j] * dot(wx, p);
  }
  if (limit > 0) {
    const float linear = linear_at(channel, place);
    value = min(max(value, linear - limit), linear + limit);
  }
  return value;
}
