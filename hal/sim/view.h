// A scene at one instant, seen by its camera: casts rays and returns hits. A ray is the point (x, y) of the
// plane one metre ahead, so that its parameter is the depth itself (camera z, metres). pose_at() fills a view
// without allocating after the first time; the other methods are reentrant.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/sim/scene.h"

namespace hdrcam {

struct Hit {
  float depth_m = 0;  // camera z
  int object = 0;     // index into Scene::objects; the dome catches every ray
  int part = 0;       // face of a box or of a ball's texture: neighbours on one part share a smooth texture
  Vec3 point;         // in the object's own coordinates, before its pulse
  Vec3 normal;        // there, facing the ray; not of the dome
};

// A box of rays.
struct RayBox {
  float x0 = 0, x1 = 0, y0 = 0, y1 = 0;

  bool holds(Vec2 ray) const { return ray.x >= x0 && ray.x <= x1 && ray.y >= y0 && ray.y <= y1; }
  bool meets(const RayBox& other) const {
    return x0 <= other.x1 && x1 >= other.x0 && y0 <= other.y1 && y1 >= other.y0;
  }
  void include(const RayBox& other) {
    x0 = std::min(x0, other.x0), x1 = std::max(x1, other.x1);
    y0 = std::min(y0, other.y0), y1 = std::max(y1, other.y1);
  }
  void include(Vec2 ray) { include({ray.x, ray.x, ray.y, ray.y}); }
};

class View {
 public:
  void pose_at(const Scene& scene, double time_s);

  Hit cast(Vec2 ray) const;
  // Like cast(ray), for callers that know that only these objects and the dome can be hit.
  Hit cast(Vec2 ray, std::span<const std::uint8_t> objects) const;
  // Rays outside never hit the object; unbounded for dome and ground.
  const RayBox& bounds(int object) const { return seen_[static_cast<std::size_t>(object)].bounds; }
  // footprint: width of the sample, in rays, for the filter of the textures.
  Colour radiance(const Hit& hit, float footprint) const;
  // The projection of an object's point: the ray and its depth (<= 0: behind the camera).
  Vec3 project(int object, Vec3 point) const;

  const Pose& camera() const { return camera_; }

 private:
  struct Seen {
    RayBox bounds;
    // In the object's size before its pulse: lengths shrink as the object grows.
    Mat3 shrunk_R_object_camera;
    Vec3 shrunk_eye;  // the camera, in the object's coordinates
    Vec3 centre;      // the object, in camera axes
    float size = 1;   // pulse
  };
  // Where a ray first hits an object; at infinity where it does not.
  struct Meeting {
    float depth_m;
    int axis = 0;  // through which a box is entered
  };
  struct Light {
    Vec3 position;  // world
    Colour power;   // irradiance at one metre
  };
  static void bound(Seen& seen, float radius);
  Meeting meet(int object, Vec2 ray) const;
  template <class Object>
  Hit nearest_of(Vec2 ray, std::size_t count, Object object_at) const;
  Hit hit_at(Vec2 ray, int object, Meeting where) const;
  Colour lit(const Hit& hit, Colour albedo) const;

  const Scene* scene_ = nullptr;
  Pose camera_;
  std::vector<Seen> seen_;
  std::vector<PosedObject> posed_;
  std::vector<Light> lights_;
};

}  // namespace hdrcam
