// How a picture as a whole has moved from where it was predicted.
#include "online/priors/motion/camera_shake.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 120, kCols = 160;

// Codes of a texture that does not repeat itself, moved by so many pixels, with noise of so many codes.
// across: how strong what is not striped is, against the stripes.
Image<float> picture(Offset moved, double noise_codes, unsigned seed, double across = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_codes);
  Image<float> codes(1, kRows, kCols);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const double u = x - static_cast<double>(moved.x), v = y - static_cast<double>(moved.y);
      const double texture =
          std::sin(0.31 * u + 0.17 * v) +
          across * (std::sin(0.23 * v - 0.11 * u) + std::sin(0.07 * u) * std::cos(0.09 * v));
      codes.at(0, y, x) = static_cast<float>(40 + 5 * texture + (noise_codes > 0 ? noise(random) : 0));
    }
  return codes;
}

// To where a state's pixels were, the same for all.
Image<float> motion_of(Offset vector) {
  Image<float> motion(2, kRows, kCols);
  for (std::size_t i = 0; i < motion.plane_size(); ++i)
    motion.plane(0)[i] = vector.x, motion.plane(1)[i] = vector.y;
  return motion;
}

// Each pixel as a square of so many.
Image<float> enlarged(const Image<float>& picture, int side) {
  Image<float> large(1, side * picture.rows(), side * picture.cols());
  for (int y = 0; y < large.rows(); ++y)
    for (int x = 0; x < large.cols(); ++x) large.at(0, y, x) = picture.at(0, y / side, x / side);
  return large;
}

void check_near(Offset found, Offset expected) {
  CHECK(found.x == Approx(expected.x).margin(0.2));
  CHECK(found.y == Approx(expected.y).margin(0.2));
}

}  // namespace

TEST_CASE("a picture that has moved as a whole is followed through noise as strong as what it shows") {
  WorkerPool pool(2);
  CameraShake shake(kRows, kCols);
  for (const double noise_codes : {0., 6.})
    for (const Offset moved : {Offset{3, -1}, Offset{-2, 2}, Offset{1, 0.5f}}) {
      CAPTURE(noise_codes, moved.x, moved.y);
      const Image<float> state = picture({0, 0}, 0, 1), frame = picture(moved, noise_codes, 2);
      check_near(shake.measure(frame, state, motion_of({0, 0}), 1, pool), {-moved.x, -moved.y});
    }
}

TEST_CASE("a large picture is asked in the same halves as a small one, and tells the same shake") {
  WorkerPool pool(1);
  const Image<float> state = picture({0, 0}, 0, 1), frame = picture({3, -1}, 6, 2);
  const auto shake_of = [&](int side) {
    CameraShake shake(side * kRows, side * kCols);
    const Image<float> at_rest(2, side * kRows, side * kCols);
    return shake.measure(enlarged(frame, side), enlarged(state, side), at_rest, 1, pool);
  };
  const Offset small = shake_of(2), large = shake_of(4);
  check_near(0.5f * small, {-3, 1});
  CHECK(large.x == Approx(2 * small.x).margin(1e-4));
  CHECK(large.y == Approx(2 * small.y).margin(1e-4));
}

TEST_CASE("what is predicted is no shake, for whatever step it was predicted") {
  WorkerPool pool(1);
  CameraShake shake(kRows, kCols);
  const Image<float> state = picture({0, 0}, 0, 1), frame = picture({4, 2}, 3, 2);
  check_near(shake.measure(frame, state, motion_of({-4, -2}), 1, pool), {0, 0});
  const Image<float> half_way = picture({2, 1}, 3, 2);
  check_near(shake.measure(half_way, state, motion_of({-4, -2}), 0.5f, pool), {0, 0});
  check_near(shake.measure(frame, state, motion_of({-2, -2}), 1, pool), {-2, 0});
}

TEST_CASE("pictures that do not show the same have no shake") {
  WorkerPool pool(1);
  CameraShake shake(kRows, kCols);
  const Image<float> state = picture({0, 0}, 0, 1);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Image<float> noise(1, kRows, kCols), white(1, kRows, kCols);
    std::mt19937 random(seed);
    std::normal_distribution<float> codes(20, 3);
    for (float& code : noise.samples()) code = codes(random);
    white.fill(255);
    check_near(shake.measure(noise, state, motion_of({0, 0}), 1, pool), {0, 0});
    check_near(shake.measure(white, state, motion_of({0, 0}), 1, pool), {0, 0});
  }
}

TEST_CASE("across the stripes of a picture its halves tell a shake, though not along them") {
  WorkerPool pool(1);
  CameraShake shake(kRows, kCols);
  const Offset moved{2, 1}, normal{0.88f, 0.48f};  // of the stripes
  const Image<float> state = picture({0, 0}, 0, 1, 0.05);
  for (unsigned seed = 2; seed <= 11; ++seed) {
    CAPTURE(seed);
    const Offset found = shake.measure(picture(moved, 6, seed, 0.05), state, motion_of({0, 0}), 1, pool);
    CHECK(found.x * normal.x + found.y * normal.y ==
          Approx(-moved.x * normal.x - moved.y * normal.y).margin(0.2));
  }
}

TEST_CASE("a shake is the same for any number of threads, and none for a picture too small to tell") {
  const Image<float> state = picture({0, 0}, 0, 1), frame = picture({2, 1}, 6, 2);
  WorkerPool one(1), three(3);
  CameraShake shake(kRows, kCols);
  const Offset a = shake.measure(frame, state, motion_of({0, 0}), 1, one),
               b = shake.measure(frame, state, motion_of({0, 0}), 1, three);
  CHECK((a.x == b.x && a.y == b.y));
  CameraShake of_strip(20, 400);
  const Image<float> strip(1, 20, 400), motion(2, 20, 400);
  check_near(of_strip.measure(strip, strip, motion, 1, one), {0, 0});
}
