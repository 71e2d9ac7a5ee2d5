// The surroundings as log2 radiance over directions: sky and street, a hall, a city at night.
#include <cmath>
#include <numbers>

#include "hal/core/smooth_step.h"
#include "hal/sim/texture.h"
#include "hal/sim/value_noise.h"

namespace hdrcam {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

struct Look {
  Vec3 direction;       // normalised
  float azimuth = 0;    // radians, 0 ahead, to the right
  float elevation = 0;  // sine of the angle above the horizon
  std::uint32_t seed = 0;
};

// Houses along the horizon: the place within the front of one of them, or nothing.
struct House {
  bool hit = false;
  int number = 0;
  float across = 0, up = 0;  // in windows
};
House house_at(const Look& look, float lowest, float spread) {
  constexpr float kHouses = 22;
  const float place = (look.azimuth / (2 * kPi) + 0.5f) * kHouses;
  House house;
  house.number = static_cast<int>(place);
  const float roof = lowest + spread * (0.5f + 0.5f * lattice_value(house.number, 0, 1, look.seed));
  house.hit = look.elevation > -0.12f && look.elevation < roof;
  house.across = (place - static_cast<float>(house.number)) * 6;
  house.up = (look.elevation + 0.12f) * 26;
  return house;
}
// 1 inside a window of the front, 0 on the wall
bool in_window(const House& house) {
  const float x = house.across - std::floor(house.across), y = house.up - std::floor(house.up);
  return x > 0.28f && x < 0.72f && y > 0.25f && y < 0.75f;
}
float window_value(const House& house, std::uint32_t seed) {
  return lattice_value(static_cast<int>(house.across) + 64 * house.number, static_cast<int>(house.up), 2,
                       seed);
}

// The sun low over a street: 15 stops between its disc and a dark window.
Colour street(const Look& look) {
  const Vec3 sun = normalized({0.24f, -0.24f, 1});
  const float angle = std::acos(std::clamp(dot(sun, look.direction), -1.f, 1.f));
  // No house before the sun.
  const bool street_ahead = std::abs(look.azimuth - std::atan2(sun.x, sun.z)) < 0.13f;
  const House house = street_ahead ? House{} : house_at(look, 0.02f, 0.4f);
  const float grain = fractal_noise(look.direction * 40, 3, look.seed + 9);
  if (house.hit) {
    const float hue = lattice_value(house.number, 3, 0, look.seed);
    if (!in_window(house)) return grey(-1.4f + 0.9f * grain) + Colour{0.5f * hue, 0, -0.4f * hue};
    return grey(window_value(house, look.seed) > 0.6f ? 4.5f + grain : -6 + grain);
  }
  if (look.elevation <= 0) return grey(-0.8f + 1.2f * grain) + Colour{0.1f, 0, -0.15f};
  const float cloud = fractal_noise(look.direction * Vec3{3, 9, 3}, 5, look.seed + 5);
  const float haze = 3.2f * std::exp(-angle / 0.35f) + 2.5f * std::exp(-angle / 0.08f);
  const Colour sky = grey(1.2f - look.elevation) + Colour{-0.5f, 0, 0.6f} * look.elevation;
  const Colour air = sky + grey(haze) + grey(1.2f * smooth_step(-0.1f, 0.8f, cloud));
  const float disc = 1 - smooth_step(0.030f, 0.036f, angle);
  return air * (1 - disc) + Colour{9.8f, 9.5f, 9.0f} * disc;
}

// Panelled walls, one of windows, lamps in the ceiling.
Colour hall(const Look& look) {
  const Vec3 d = look.direction;
  const float grain = fractal_noise(d * 24, 4, look.seed);
  const float flat = std::hypot(d.x, d.z);
  if (d.y < -0.62f) {
    const float x = d.x / -d.y * 3, z = d.z / -d.y * 3;
    const bool lamp = std::hypot(x - std::round(x), z - std::round(z)) < 0.14f;
    return lamp ? grey(6.5f) + Colour{0.3f, 0, -0.4f} : grey(-1.2f + 0.5f * grain);
  }
  if (d.y > 0.5f) return grey(-2 + 0.8f * grain) + Colour{0.5f, 0, -0.5f};
  const float place = look.azimuth * 12 / kPi, up = d.y / flat * 3;
  const int column = static_cast<int>(std::floor(place));
  const float across = place - static_cast<float>(column), row = up - std::floor(up);
  const bool pillar = across < 0.12f;
  const bool window =
      std::abs(look.azimuth - 0.4f) < 0.75f && !pillar && up > -1.4f && up < 0.1f && row > 0.08f;
  if (window) return grey(3.6f + 0.9f * fractal_noise(d * 12, 4, look.seed + 3)) + Colour{-0.2f, 0, 0.3f};
  const float hue = lattice_value(column, static_cast<int>(std::floor(up)), 7, look.seed);
  const float groove = pillar || row < 0.05f ? -2.f : 0.f;
  return grey(-0.7f + 0.9f * grain + groove + 0.8f * hue) + Colour{0.4f * hue, 0.1f, -0.4f * hue};
}

// Black houses with a few lit windows, street lamps, the moon.
Colour night_city(const Look& look) {
  const float grain = fractal_noise(look.direction * 40, 3, look.seed + 9);
  const House house = house_at(look, 0.06f, 0.5f);
  const float lamp_place = look.azimuth * 14 / kPi;
  const float lamp = std::hypot((lamp_place - std::round(lamp_place)) * kPi / 14, look.elevation - 0.02f);
  if (lamp < 0.022f) return grey(7) + Colour{0.5f, 0, -1.2f};
  const float glow = 2.5f * std::exp(-lamp / 0.07f);
  if (house.hit) {
    const float lit = window_value(house, look.seed);
    if (in_window(house) && lit > 0.35f)
      return grey(2.5f + 2 * lit + 0.5f * grain) + Colour{0.5f, 0.1f, -0.8f};
    return grey(-4.5f + 0.9f * grain + glow) + Colour{0.3f, 0, -0.2f};
  }
  if (look.elevation <= 0) return grey(-3.4f + 1.1f * grain + glow) + Colour{0.3f, 0, -0.3f};
  const Vec3 moon = normalized({-0.3f, -0.62f, 1});
  if (dot(moon, look.direction) > std::cos(0.035f)) return grey(5.5f + 0.4f * grain);
  const float cloud = fractal_noise(look.direction * Vec3{3, 9, 3}, 5, look.seed + 5);
  return grey(-5 - look.elevation + 1.5f * cloud + 0.4f * glow) + Colour{-0.2f, 0, 0.4f};
}

Colour stops_at(Environment kind, const Look& look) {
  switch (kind) {
    case Environment::Street:
      return street(look);
    case Environment::Hall:
      return hall(look);
    case Environment::NightCity:
      break;
  }
  return night_city(look);
}

// Of texel (x, y) of a face; inverse of Panorama::at.
Vec3 direction_of(int face, float s, float t) {
  const float sign = face % 2 == 0 ? 1.f : -1.f;
  switch (face / 2) {
    case 0:
      return {sign, t, s};
    case 1:
      return {s, sign, t};
    default:
      return {s, t, sign};
  }
}

}  // namespace

Panorama::Panorama(Environment kind, std::uint64_t seed, int face_px, WorkerPool& pool)
    : side_(face_px), texels_(static_cast<std::size_t>(6 * face_px * face_px)) {
  const auto noise_seed = static_cast<std::uint32_t>(seed * 0x9e3779b9u + 77);
  pool.for_each(6 * side_, [&](int row) {
    const float t = (static_cast<float>(row % side_) + 0.5f) / static_cast<float>(side_) * 2 - 1;
    for (int x = 0; x < side_; ++x) {
      const float s = (static_cast<float>(x) + 0.5f) / static_cast<float>(side_) * 2 - 1;
      const Vec3 d = normalized(direction_of(row / side_, s, t));
      texels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x)] =
          texel_of(exp2(stops_at(kind, {d, std::atan2(d.x, d.z), -d.y, noise_seed})));
    }
  });
}

Colour Panorama::at(Vec3 d) const {
  const float ax = std::abs(d.x), ay = std::abs(d.y), az = std::abs(d.z);
  int face;
  float s, t, away;
  if (az >= ax && az >= ay)
    face = d.z > 0 ? 4 : 5, s = d.x, t = d.y, away = az;
  else if (ax >= ay)
    face = d.x > 0 ? 0 : 1, s = d.z, t = d.y, away = ax;
  else
    face = d.y > 0 ? 2 : 3, s = d.x, t = d.z, away = ay;
  s *= 1 / away, t *= 1 / away;
  const float half = 0.5f * static_cast<float>(side_), last = static_cast<float>(side_) - 1.001f;
  const float x = std::clamp((s + 1) * half - 0.5f, 0.f, last),
              y = std::clamp((t + 1) * half - 0.5f, 0.f, last);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const Texel* above =
      &texels_[(static_cast<std::size_t>(face * side_ + y0)) * static_cast<std::size_t>(side_)];
  const Texel* below = above + side_;
  const Texel top = above[x0] + fx * (above[x0 + 1] - above[x0]);
  const Texel bottom = below[x0] + fx * (below[x0 + 1] - below[x0]);
  return colour_of(top + fy * (bottom - top));
}

}  // namespace hdrcam
