#include "online/state/texture_error.h"

#include <cmath>

#include "online/pictures/local_statistics.h"
#include "online/state/fusion.h"
#include "tests/online/state/known_scene.h"
#include "tests/support/coded_frame.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::quiet_tables;

namespace {

constexpr int kRows = 72, kCols = 96;
const float kUnseen = unseen_variance_from(4);

// What one frame shows of a texture that the state knows, moved by whole pixels.
struct Texture {
  static constexpr int kShift = 2;
  RadianceState state;
  FlowField motion = test::uniform_flow(kRows, kCols, kShift);
  ExposedFrame frame;
  WorkerPool pool{1};

  explicit Texture(float amplitude)
      : state(
            test::known_scene(kRows, kCols, [&](int c, int y, int x) { return light(amplitude, c, y, x); })),
        frame(test::coded_frame(kRows, kCols, [&](int c, int y, int x) {
          return std::round(quiet_tables().code(c, light(amplitude, c, y, x + kShift)));
        })) {}
  static float light(float amplitude, int c, int y, int x) {
    return 0.2f + amplitude * static_cast<float>(std::sin(1.3 * x + c) * std::sin(1.1 * y));
  }
  // As noise reduction does: each pixel nearer to the mean of its surroundings.
  void smooth(float share) {
    Image<float> mean;
    box_mean(frame.codes, 1, mean, pool);
    for (std::size_t i = 0; i < mean.size(); ++i)
      frame.codes.plane(0)[i] += share * (mean.plane(0)[i] - frame.codes.plane(0)[i]);
  }
  float found(int frames = 20) {
    TextureError error(pool);
    for (int i = 0; i < frames; ++i) error.observe({frame, state, motion, quiet_tables(), kUnseen});
    return error.share();
  }
};

}  // namespace

TEST_CASE("what a camera's processing makes of textures is seen, and a camera that shows them is believed") {
  Texture texture(0.1f);
  CHECK(texture.found() == 0);
  texture.smooth(0.8f);
  CHECK(texture.found() > 0.02f);
  WorkerPool pool(1);
  CHECK(TextureError(pool, kTextureErrorOfMosaic).share() == kTextureErrorOfMosaic);
  texture.motion.confidence.fill(0.5f);
  CHECK(texture.found() == 0);  // perhaps it is the motion
  Texture flat(0.001f);
  flat.smooth(0.8f);
  CHECK(flat.found() == 0);
}

TEST_CASE(
    "where processing changes textures a sample of a texture weighs less, one of a flat place as before") {
  const auto variance_after = [](float amplitude, float texture_error, float code_noise = 0.1f) {
    Texture texture(amplitude);
    Fusion fusion({}, texture.pool);
    NoiseModel noise;
    noise.full_well = test::kQuietWell, noise.code_noise = code_noise;
    ExposureTables sampled(Response::gamma(2.2f), noise, 1);
    sampled.set_texture_error(texture_error);
    Samples samples;
    Image<float> share;
    fusion.sample(texture.frame.codes, texture.frame.codes, sampled, samples);
    texture.state.variance.fill(1e-3f);
    RadianceState updated;
    fusion.update({texture.state, samples, sampled, kUnseen}, nullptr, nullptr, updated, share);
    return updated.variance.at(1, kRows / 2, kCols / 2);
  };
  CHECK(variance_after(0, 0.1f) == Approx(variance_after(0, 0)).epsilon(1e-3));
  CHECK(variance_after(0.1f, 0.1f) > 2 * variance_after(0.1f, 0));
  CHECK(variance_after(0.1f, 0, 1) >
        3 * variance_after(0, 0, 1));  // of compressed codes even without a share
}
