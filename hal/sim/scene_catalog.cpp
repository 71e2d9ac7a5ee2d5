#include "hal/sim/scene_catalog.h"

#include <algorithm>
#include <numbers>

#include "hal/sim/counter_random.h"
#include "hal/sim/view.h"

namespace hdrcam {
namespace {

using Need = CatalogScene::Need;

constexpr Need kNoise{Effect::Noise, "photon noise is in every exposure"};
constexpr Need kResponse{Effect::Response, "a camera that delivers pictures has a tone curve"};
constexpr Need kDelay{Effect::ControlDelay, "a sensor applies a control some frames after it is written"};
constexpr Need kBlur{Effect::MotionBlur, "objects or camera move during the longest exposure"};

constexpr Need kStillNeeds[] = {kNoise, kResponse, kDelay};
constexpr Need kWalkNeeds[] = {kNoise, kResponse, kDelay, kBlur, {Effect::Vignetting, "a wide lens"}};
constexpr Need kNightNeeds[] = {kNoise,
                                kResponse,
                                kDelay,
                                kBlur,
                                {Effect::HotPixels, "long exposures of a warm sensor"},
                                {Effect::MainsFlicker, "street lamps on 50 Hz mains"},
                                {Effect::Flare, "lamps before black houses"}};
constexpr Need kFastNeeds[] = {
    kNoise,
    kResponse,
    kDelay,
    kBlur,
    {Effect::RollingShutter, "rows are exposed at different moments of a fast motion"}};
constexpr Need kLampsNeeds[] = {kNoise, kResponse, kDelay, kBlur, {Effect::Flare, "lamps in the picture"}};
constexpr Need kPanNeeds[] = {kNoise,
                              kResponse,
                              kDelay,
                              kBlur,
                              {Effect::RollingShutter, "a turning camera skews the picture"},
                              {Effect::Distortion, "a wide lens, swept along a skyline"}};

constexpr CatalogScene kCatalog[] = {
    {"still",
     "nothing moves: a tripod in a hall",
     {0, 1, 4, 1, 0, 0, CameraMove::Still},
     Environment::Hall,
     4,
     0.18f,
     6000,
     kStillNeeds},
    {"walk",
     "a street against the sun, hand-held, four things move",
     {1, 1, 6, 1, 1, 0, CameraMove::Handheld},
     Environment::Street,
     4,
     0.18f,
     6000,
     kWalkNeeds},
    {"night",
     "a city at night: lamps, hot pixels, few photons, one pulsating ball",
     {2, 1, 5, 3, 1, 0.2f, CameraMove::Handheld},
     Environment::NightCity,
     4,
     0.06f,
     1500,
     kNightNeeds},
    {"fast",
     "a fast pan over fast objects: long blur, rolling shutter",
     {3, 1, 6, 1, 2.5f, 0, CameraMove::Pan},
     Environment::Street,
     4,
     0.18f,
     6000,
     kFastNeeds},
    {"lamps",
     "an orbit around lamps that light nearby objects",
     {4, 1, 6, 4, 0.7f, 0, CameraMove::Orbit},
     Environment::Hall,
     4,
     0.18f,
     6000,
     kLampsNeeds},
    {"pan",
     "a turning camera, no parallax, nothing else moves",
     {5, 1, 0, 0, 0.6f, 0, CameraMove::Pan},
     Environment::Street,
     4,
     0.18f,
     6000,
     kPanNeeds},
};

constexpr int kTextures = 6;  // as radiance; behind them the same as albedo
constexpr Pattern kPatterns[] = {Pattern::Stone, Pattern::Tiles, Pattern::Facade, Pattern::Stripes};
constexpr float kTurn = 2 * std::numbers::pi_v<float>;

// Numbers for one thing of the scene, drawn in turn.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t stream, int thing)
      : random_(seed, stream, static_cast<std::uint64_t>(thing)) {}
  float between(float begin, float end) { return random_.uniform(counter_++, begin, end); }
  Vec3 between(Vec3 begin, Vec3 end) {
    const float x = between(begin.x, end.x), y = between(begin.y, end.y);
    return {x, y, between(begin.z, end.z)};
  }

 private:
  CounterRandom random_;
  std::uint64_t counter_ = 0;
};

SceneObject floating_object(const SceneSettings& settings, int i, float distance_m) {
  Draw draw(settings.seed * 16 + static_cast<std::uint64_t>(settings.scene), 0x6f626a, i);
  constexpr Shape kShapes[] = {Shape::Box, Shape::Ball, Shape::Panel};
  SceneObject object;
  object.shape = kShapes[i % 3];
  object.surface = i % 2 == 0 ? Surface::Radiant : Surface::Lit;
  const float z = distance_m * draw.between(0.62f, 1.15f), size = z * draw.between(0.09f, 0.16f);
  object.half_size_m = {size, size * draw.between(0.7f, 1.3f), size};
  if (object.shape == Shape::Ball) object.half_size_m = {size, size, size};
  object.centre_m = {z * draw.between(-0.45f, 0.45f), z * draw.between(-0.26f, 0.24f), z};
  object.texture = static_cast<int>(draw.between(0, kTextures - 0.01f));
  if (object.surface == Surface::Lit) object.texture += kTextures;
  object.tiles_per_m = draw.between(0.35f, 0.6f) / size;
  object.gain = object.surface == Surface::Lit ? 1 : draw.between(0.25f, 2);
  ObjectMotion& motion = object.motion;
  motion.axis = {draw.between(-0.4f, 0.4f), 1, draw.between(-0.4f, 0.4f)};
  motion.angle_rad = draw.between(-0.6f, 0.6f);
  if (i % 3 == 2 || settings.speed == 0) return object;
  const float turn = object.shape == Shape::Panel ? 0.4f : 1.1f;
  motion.turn_rad_per_s = settings.speed * draw.between(-turn, turn);
  motion.swing_m = draw.between({0.1f, 0.02f, 0.02f}, {0.28f, 0.1f, 0.08f}) * (z * settings.speed);
  if (settings.speed > 1) motion.swing_m = motion.swing_m * (1 / settings.speed);  // faster, but not farther
  motion.swing_hz = draw.between({0.25f, 0.3f, 0.2f}, {0.6f, 0.8f, 0.5f}) * std::max(1.f, settings.speed);
  motion.swing_phase_rad = draw.between({}, {kTurn, kTurn, kTurn});
  if (object.shape == Shape::Ball && settings.pulse > 0)
    motion.pulse = settings.pulse, motion.pulse_hz = draw.between(0.5f, 1);
  return object;
}

SceneObject lamp(const SceneSettings& settings, int i, float distance_m) {
  Draw draw(settings.seed * 16 + static_cast<std::uint64_t>(settings.scene), 0x6c616d70, i);
  SceneObject object;
  object.surface = Surface::Lamp;
  const float z = distance_m * draw.between(0.75f, 1.2f), size = 0.028f * z;
  object.half_size_m = {size, size, size};
  object.centre_m = {z * draw.between(-0.4f, 0.4f), z * draw.between(-0.28f, 0.02f), z};
  object.colour = {1, draw.between(0.7f, 1), draw.between(0.4f, 0.9f)};
  object.gain = draw.between(150, 400);
  if (i % 2 == 1) {
    object.motion.swing_m = Vec3{0.2f, 0.05f, 0} * (z * std::min(1.f, settings.speed));
    object.motion.swing_hz = Vec3{0.5f, 0.7f, 0} * std::max(1.f, settings.speed);
  }
  return object;
}

SceneObject dome(float radius_m) {
  SceneObject object;
  object.shape = Shape::Dome;
  object.half_size_m = {radius_m, radius_m, radius_m};
  return object;
}

SceneObject street_ground(float radius_m) {
  SceneObject object;
  object.shape = Shape::Ground;
  object.half_size_m = {radius_m, 0, radius_m};
  object.centre_m = {0, 1.5f, 0};
  object.tiles_per_m = 0.3f;
  object.gain = 0.5f;
  return object;
}

float median_luminance(const Scene& scene) {
  constexpr int kGrid = 48;
  View view;
  view.pose_at(scene, 0);
  std::vector<float> samples;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const auto along = [](int k) { return (static_cast<float>(k) + 0.5f) / kGrid - 0.5f; };
    const Hit hit = view.cast({along(i % kGrid), 0.75f * along(i / kGrid)});
    samples.push_back(luminance(view.radiance(hit, 1.f / kGrid)));
  }
  std::nth_element(samples.begin(), samples.begin() + kGrid * kGrid / 2, samples.end());
  return samples[kGrid * kGrid / 2];
}

}  // namespace

std::span<const CatalogScene> scene_catalog() { return kCatalog; }

Scene make_scene(const SceneSettings& settings, int face_px, WorkerPool& pool) {
  const CatalogScene& entry = kCatalog[settings.scene];
  const bool street = entry.environment != Environment::Hall;
  const float dome_radius_m = entry.distance_m * (street ? 10 : 2);
  Scene scene{.name = entry.name,
              .objects = {dome(dome_radius_m)},
              .textures = {},
              .panorama = Panorama(entry.environment, settings.seed, face_px, pool),
              .camera = CameraPath(settings.camera, settings.seed, entry.distance_m, settings.speed)};
  for (std::size_t i = 0; i < kTextures; ++i)
    scene.textures.emplace_back(kPatterns[i % std::size(kPatterns)], settings.seed * 31 + i);
  for (std::size_t i = 0; i < kTextures; ++i) scene.textures.push_back(scene.textures[i].albedo());
  if (street) scene.objects.push_back(street_ground(dome_radius_m * 0.9f));
  for (int i = 0; i < settings.objects; ++i)
    scene.objects.push_back(floating_object(settings, i, entry.distance_m));
  for (int i = 0; i < settings.lamps; ++i) scene.objects.push_back(lamp(settings, i, entry.distance_m));
  if (entry.environment == Environment::NightCity) {
    const float dim = 1.f / 64;  // the surroundings' own light, darker than lamps and lit surfaces
    scene.ambient = scene.ambient * dim, scene.from_above = scene.from_above * dim;
    for (SceneObject& object : scene.objects) {
      if (object.shape != Shape::Dome && object.surface == Surface::Radiant) object.gain *= 2 * dim;
      if (object.surface == Surface::Lamp) object.gain *= 0.5f;
    }
  }
  scene.radiance_scale = entry.median / median_luminance(scene);
  return scene;
}

}  // namespace hdrcam
