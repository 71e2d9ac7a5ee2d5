#include "hal/sim/view.h"

#include <limits>

namespace hdrcam {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
constexpr float kNearest_m = 1e-3f;

// Each returns the parameter of the first hit of eye + t d in front of the camera, or kNever.
float meet_ball(Vec3 eye, Vec3 d, float radius) {
  const float a = dot(d, d), b = dot(eye, d), c = dot(eye, eye) - radius * radius;
  const float discriminant = b * b - a * c;
  if (discriminant < 0) return kNever;
  const float t = (-b - std::sqrt(discriminant)) / a;
  return t > kNearest_m ? t : kNever;
}

float meet_dome(Vec3 eye, Vec3 d, float radius) {  // from inside
  const float a = dot(d, d), b = dot(eye, d), c = dot(eye, eye) - radius * radius;
  return (-b + std::sqrt(std::max(0.f, b * b - a * c))) / a;
}

struct BoxHit {
  float t = kNever;
  int axis = 0;
};
BoxHit meet_box(Vec3 eye, Vec3 d, Vec3 half) {
  const float o[3] = {eye.x, eye.y, eye.z}, w[3] = {d.x, d.y, d.z}, h[3] = {half.x, half.y, half.z};
  float enter = -kNever, leave = kNever;
  BoxHit hit;
  for (int axis = 0; axis < 3; ++axis) {
    // Infinite for a parallel ray: the slab then contains all of it or nothing.
    const float inverse = 1 / w[axis];
    float t0 = (-h[axis] - o[axis]) * inverse, t1 = (h[axis] - o[axis]) * inverse;
    if (t0 > t1) std::swap(t0, t1);
    if (t0 > enter) enter = t0, hit.axis = axis;
    leave = std::min(leave, t1);
  }
  if (enter <= leave && enter > kNearest_m) hit.t = enter;
  return hit;
}

float meet_panel(Vec3 eye, Vec3 d, Vec3 half) {
  const float t = -eye.z / d.z;
  if (!(t > kNearest_m) || std::abs(eye.x + t * d.x) > half.x || std::abs(eye.y + t * d.y) > half.y)
    return kNever;
  return t;
}

float meet_ground(Vec3 eye, Vec3 d, float radius) {
  const float t = -eye.y / d.y;
  if (!(t > kNearest_m)) return kNever;
  const float x = eye.x + t * d.x, z = eye.z + t * d.z;
  return x * x + z * z < radius * radius ? t : kNever;
}

float bounding_radius(const SceneObject& object) {
  switch (object.shape) {
    case Shape::Ball:
      return object.half_size_m.x;
    case Shape::Box:
      return length(object.half_size_m);
    case Shape::Panel:
      return std::hypot(object.half_size_m.x, object.half_size_m.y);
    case Shape::Ground:
    case Shape::Dome:
      break;
  }
  return kNever;
}

// Interval of rays x = X / Z that meet a circle of `radius` around (x, z), seen from the origin.
struct Interval {
  float begin = -kNever, end = kNever;
};
Interval seen_interval(float x, float z, float radius) {
  const float beyond = z * z - radius * radius;
  if (z < 0 || beyond <= 0) return {};
  const float root = radius * std::sqrt(std::max(0.f, x * x + beyond));
  return {(x * z - root) / beyond, (x * z + root) / beyond};
}

float along(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// The axis with the largest coordinate of a point: a ball is textured like an inflated cube.
int dominant_axis(Vec3 p) {
  const float x = std::abs(p.x), y = std::abs(p.y), z = std::abs(p.z);
  return z >= x && z >= y ? 2 : x >= y ? 0 : 1;
}

// The texture coordinates, in metres over the surface.
Vec2 unrolled(const SceneObject& object, const Hit& hit) {
  constexpr float kFaceShift_m = 0.37f;  // so that faces differ
  // Of a ball's radius: half the arc of a face of the cube that it is the inflation of.
  constexpr float kHalfArc = 0.785f;
  Vec3 p = hit.point;
  switch (object.shape) {
    case Shape::Panel:
      return {p.x, p.y};
    case Shape::Ground:
      return {p.x, p.z};
    case Shape::Ball:
      p = p * (kHalfArc * object.half_size_m.x / std::abs(along(p, hit.part / 2)));
      break;
    case Shape::Box:
    case Shape::Dome:
      break;
  }
  const float shift = kFaceShift_m * static_cast<float>(hit.part);
  const int axis = hit.part / 2;
  return axis == 0 ? Vec2{p.z + shift, p.y} : axis == 1 ? Vec2{p.x, p.z + shift} : Vec2{p.x + shift, p.y};
}

}  // namespace

void View::bound(Seen& seen, float radius) {
  if (radius == kNever) {
    seen.bounds = {-kNever, kNever, -kNever, kNever};
    return;
  }
  const float r = radius * seen.size;
  if (seen.centre.z < -r) {  // behind
    seen.bounds = {kNever, -kNever, kNever, -kNever};
    return;
  }
  const Interval across = seen_interval(seen.centre.x, seen.centre.z, r);
  const Interval down = seen_interval(seen.centre.y, seen.centre.z, r);
  seen.bounds = {across.begin, across.end, down.begin, down.end};
}

void View::pose_at(const Scene& scene, double time_s) {
  scene_ = &scene;
  camera_ = scene.camera.at(time_s);
  seen_.resize(scene.objects.size());
  posed_.resize(scene.objects.size());
  lights_.reserve(scene.objects.size());
  lights_.clear();
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const PosedObject posed = posed_[i] = pose_of(object, time_s);
    Seen& seen = seen_[i];
    const Mat3& R_world_object = posed.T_world_object.rotation;
    const Vec3 offset = camera_.position - posed.T_world_object.position;
    const Mat3 R = transposed_times(R_world_object, camera_.rotation);
    const float shrink = 1 / posed.size;
    seen.shrunk_R_object_camera = {R.c0 * shrink, R.c1 * shrink, R.c2 * shrink};
    seen.shrunk_eye = transposed_times(R_world_object, offset) * shrink;
    seen.centre = transposed_times(camera_.rotation, offset * -1);
    seen.size = posed.size;
    bound(seen, bounding_radius(object));
    if (object.surface == Surface::Lamp) {
      const float radius = object.half_size_m.x;
      lights_.push_back({posed.T_world_object.position, object.colour * (object.gain * radius * radius)});
    }
  }
}

Hit View::cast(Vec2 ray) const {
  return nearest_of(ray, seen_.size() - 1, [](std::size_t i) { return static_cast<int>(i) + 1; });
}

Hit View::cast(Vec2 ray, std::span<const std::uint8_t> objects) const {
  return nearest_of(ray, objects.size(), [&](std::size_t i) { return int{objects[i]}; });
}

// Of the objects object_at(0) .. object_at(count - 1) and, behind all, the dome.
template <class Object>
Hit View::nearest_of(Vec2 ray, std::size_t count, Object object_at) const {
  int nearest = Scene::kDome;
  Meeting where{kNever};
  for (std::size_t i = 0; i < count; ++i) {
    const int object = object_at(i);
    if (!bounds(object).holds(ray)) continue;
    const Meeting met = meet(object, ray);
    if (met.depth_m < where.depth_m) where = met, nearest = object;
  }
  return hit_at(ray, nearest, nearest == Scene::kDome ? meet(Scene::kDome, ray) : where);
}

View::Meeting View::meet(int index, Vec2 ray) const {
  const Seen& seen = seen_[static_cast<std::size_t>(index)];
  const SceneObject& object = scene_->objects[static_cast<std::size_t>(index)];
  const Vec3 eye = seen.shrunk_eye, direction = seen.shrunk_R_object_camera * Vec3{ray.x, ray.y, 1};
  switch (object.shape) {
    case Shape::Ball:
      return {meet_ball(eye, direction, object.half_size_m.x)};
    case Shape::Box: {
      const BoxHit met = meet_box(eye, direction, object.half_size_m);
      return {met.t, met.axis};
    }
    case Shape::Panel:
      return {meet_panel(eye, direction, object.half_size_m)};
    case Shape::Ground:
      return {meet_ground(eye, direction, object.half_size_m.x)};
    case Shape::Dome:
      break;
  }
  return {meet_dome(eye, direction, object.half_size_m.x)};
}

Hit View::hit_at(Vec2 ray, int index, Meeting where) const {
  const Seen& seen = seen_[static_cast<std::size_t>(index)];
  const Vec3 eye = seen.shrunk_eye, direction = seen.shrunk_R_object_camera * Vec3{ray.x, ray.y, 1};
  Hit hit;
  hit.depth_m = where.depth_m, hit.object = index;
  hit.point = eye + direction * where.depth_m;
  const int axis = where.axis;
  const SceneObject& object = scene_->objects[static_cast<std::size_t>(hit.object)];
  switch (object.shape) {
    case Shape::Ball: {
      hit.normal = normalized(hit.point);
      const int facing = dominant_axis(hit.point);
      hit.part = 2 * facing + (along(hit.point, facing) < 0);
      break;
    }
    case Shape::Box: {
      const bool upper = along(direction, axis) < 0;  // the ray enters through the face at +half
      const float out = upper ? 1.f : -1.f;
      hit.normal = axis == 0 ? Vec3{out, 0, 0} : axis == 1 ? Vec3{0, out, 0} : Vec3{0, 0, out};
      hit.part = 2 * axis + !upper;
      break;
    }
    case Shape::Panel:
      hit.normal = {0, 0, direction.z > 0 ? -1.f : 1.f};
      break;
    case Shape::Ground:
      hit.normal = {0, -1, 0};
      break;
    case Shape::Dome:
      break;  // its texture needs none
  }
  return hit;
}

Colour View::radiance(const Hit& hit, float footprint) const {
  const SceneObject& object = scene_->objects[static_cast<std::size_t>(hit.object)];
  if (object.surface == Surface::Lamp) return object.colour * (object.gain * scene_->radiance_scale);
  if (object.shape == Shape::Dome)
    return scene_->panorama.at(hit.point) * (object.gain * scene_->radiance_scale);
  const Vec2 place = unrolled(object, hit);
  const Seen& seen = seen_[static_cast<std::size_t>(hit.object)];
  const Vec3 to_eye = seen.shrunk_eye - hit.point;
  constexpr float kFlattest = 0.05f;  // cosine: flatter views are filtered like this one
  const float away = length(to_eye), facing = std::max(kFlattest * away, dot(to_eye, hit.normal));
  const float side = Texture::kSide * object.tiles_per_m * footprint * hit.depth_m / seen.size;
  const float texels = side * side * away / facing;
  const Texture& texture = scene_->textures[static_cast<std::size_t>(object.texture)];
  const Colour colour =
      texture.at(place.x * object.tiles_per_m, place.y * object.tiles_per_m, texels) * object.colour;
  if (object.surface == Surface::Radiant) return colour * (object.gain * scene_->radiance_scale);
  return lit(hit, colour * object.gain) * scene_->radiance_scale;
}

// Lambert's law under the ambient light and point lamps; no shadows.
Colour View::lit(const Hit& hit, Colour albedo) const {
  const PosedObject& posed = posed_[static_cast<std::size_t>(hit.object)];
  const Vec3 normal = posed.T_world_object.rotation * hit.normal;
  const Vec3 place = posed.T_world_object.rotation * (hit.point * posed.size) + posed.T_world_object.position;
  Colour light = scene_->ambient + scene_->from_above * std::max(0.f, -normal.y);
  for (const Light& lamp : lights_) {
    const Vec3 to_lamp = lamp.position - place;
    constexpr float kNearestSquared_m2 = 1e-4f;
    const float squared = std::max(kNearestSquared_m2, dot(to_lamp, to_lamp));
    const float cosine = dot(to_lamp, normal) / std::sqrt(squared);
    if (cosine > 0) light = light + lamp.power * (cosine / squared);
  }
  return albedo * light;
}

Vec3 View::project(int object, Vec3 point) const {
  const PosedObject& posed = posed_[static_cast<std::size_t>(object)];
  const Vec3 world = posed.T_world_object.rotation * (point * posed.size) + posed.T_world_object.position;
  const Vec3 p = transposed_times(camera_.rotation, world - camera_.position);
  return {p.x / p.z, p.y / p.z, p.z};
}

}  // namespace hdrcam
